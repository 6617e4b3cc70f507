// Bytes as text, for pages that carry their data.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace ilp::host {

/// RFC 4648, with padding.
[[nodiscard]] std::string base64(std::span<const std::uint8_t> bytes);

/// The array as it lies in memory: little-endian on every machine that this runs on.
template <typename T>
[[nodiscard]] std::string base64_of(std::span<const T> values) {
  return base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size_bytes()});
}

}  // namespace ilp::host
