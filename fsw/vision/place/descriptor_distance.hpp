// Differing bits of descriptors, in plain integers and vectors of GCC and Clang: the same on every processor.
#pragma once

#include <cstdint>
#include <cstring>

namespace ilp {

inline constexpr std::size_t descriptor_words = 8;  ///< of 32 bits

/// Number of ones.
[[nodiscard]] constexpr int count_ones(std::uint64_t v) {
  v -= (v >> 1) & 0x5555555555555555ULL;
  v = (v & 0x3333333333333333ULL) + ((v >> 2) & 0x3333333333333333ULL);
  v = (v + (v >> 4)) & 0x0F0F0F0F0F0F0F0FULL;
  return static_cast<int>((v * 0x0101010101010101ULL) >> 56);
}

/// Of two descriptors of descriptor_words, 0 to 256.
[[nodiscard]] inline int hamming_256(const std::uint32_t* a, const std::uint32_t* b) {
  using Lanes [[gnu::vector_size(16)]] = std::uint64_t;
  Lanes p[2], q[2];
  std::memcpy(p, a, sizeof p);
  std::memcpy(q, b, sizeof q);
  const auto ones_of_bytes = [](Lanes v) {
    v -= (v >> 1) & 0x5555555555555555ULL;
    v = (v & 0x3333333333333333ULL) + ((v >> 2) & 0x3333333333333333ULL);
    return (v + (v >> 4)) & 0x0F0F0F0F0F0F0F0FULL;
  };
  const Lanes bytes = ones_of_bytes(p[0] ^ q[0]) + ones_of_bytes(p[1] ^ q[1]);
  // At most 32 in each byte, and 64 in each of four words.
  std::uint64_t sum = bytes[0] + bytes[1];
  sum = (sum & 0x00FF00FF00FF00FFULL) + ((sum >> 8) & 0x00FF00FF00FF00FFULL);
  return static_cast<int>((sum * 0x0001000100010001ULL) >> 48);
}

}  // namespace ilp
