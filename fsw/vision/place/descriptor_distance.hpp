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

/// The same word of four descriptors.
using FourWords [[gnu::vector_size(16)]] = std::uint32_t;

/// Whether any lane of a comparison is true.
template <typename Lanes>
[[nodiscard]] bool any(const Lanes& lanes) {
  std::uint64_t halves[2];
  static_assert(sizeof halves == sizeof lanes);
  std::memcpy(halves, &lanes, sizeof halves);
  return (halves[0] | halves[1]) != 0;
}

/// Of one descriptor, each of whose words fills all lanes, and four others; each distance is 0 to 256.
[[nodiscard]] inline FourWords hamming_256_of_four(const FourWords* one, const FourWords* others) {
  const auto ones_of_nibbles = [&](std::size_t word) {
    FourWords v = others[word] ^ one[word];
    v -= (v >> 1) & 0x55555555U;
    return (v & 0x33333333U) + ((v >> 2) & 0x33333333U);
  };
  // At most 12 in each of four bits, and 64 in each byte.
  const auto ones_of_bytes = [](FourWords v) { return (v & 0x0F0F0F0FU) + ((v >> 4) & 0x0F0F0F0FU); };
  const FourWords bytes = ones_of_bytes(ones_of_nibbles(0) + ones_of_nibbles(1) + ones_of_nibbles(2)) +
                          ones_of_bytes(ones_of_nibbles(3) + ones_of_nibbles(4) + ones_of_nibbles(5)) +
                          ones_of_bytes(ones_of_nibbles(6) + ones_of_nibbles(7));
  const FourWords halves = (bytes & 0x00FF00FFU) + ((bytes >> 8) & 0x00FF00FFU);
  return (halves & 0xFFFFU) + (halves >> 16);
}

}  // namespace ilp
