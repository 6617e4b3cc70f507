// A fingerprint of text and files, to see whether something has changed. Not for security.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace ilp::host {

/// FNV-1a of 64 bits (Fowler, Noll, Vo); pass the previous result to continue.
[[nodiscard]] constexpr std::uint64_t digest(std::string_view bytes, std::uint64_t state = 0xcbf29ce484222325U) {
  for (const char c : bytes) state = (state ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return state;
}

/// 16 hexadecimal digits.
[[nodiscard]] inline std::string digest_text(std::uint64_t state) {
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; state >>= 4) text[i] = "0123456789abcdef"[state & 15U];
  return text;
}

}  // namespace ilp::host
