// Hamming distances of binary descriptors, in integers and vector types of GCC and Clang: the same on every processor.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

namespace ilp {

inline constexpr std::size_t descriptor_words = 8;  ///< of 32 bits

/// Number of bits that are 1.
[[nodiscard]] constexpr int count_ones(std::uint64_t v) {
  v -= (v >> 1) & 0x5555555555555555ULL;
  v = (v & 0x3333333333333333ULL) + ((v >> 2) & 0x3333333333333333ULL);
  v = (v + (v >> 4)) & 0x0F0F0F0F0F0F0F0FULL;
  return static_cast<int>((v * 0x0101010101010101ULL) >> 56);
}

/// Hamming distance of two descriptors of descriptor_words, 0 to 256. Unrelated features differ in 74 (smooth ground)
/// to 112 (rough ground) on average, fewer than 128, because the comparisons are relative to the angle.
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

/// hamming_256 with the processor's instruction to count bits, if it has one.
template <typename Width>
[[nodiscard]] inline int hamming_256_with(Width /*vectors*/, const std::uint32_t* a, const std::uint32_t* b) {
  if constexpr (Width::is_wide) {
    std::uint64_t p[4], q[4];
    std::memcpy(p, a, sizeof p);
    std::memcpy(q, b, sizeof q);
    return std::popcount(p[0] ^ q[0]) + std::popcount(p[1] ^ q[1]) + std::popcount(p[2] ^ q[2]) +
           std::popcount(p[3] ^ q[3]);
  } else {
    return hamming_256(a, b);
  }
}

/// One word of each of eight descriptors.
using EightWords [[gnu::vector_size(32)]] = std::uint32_t;

/// True if any lane of a comparison is true.
template <typename Lanes>
[[nodiscard]] bool any(const Lanes& lanes) {
  std::uint64_t parts[4];
  static_assert(sizeof parts == sizeof lanes);
  std::memcpy(parts, &lanes, sizeof parts);
  return ((parts[0] | parts[1]) | (parts[2] | parts[3])) != 0;
}

/// Hamming distances of one descriptor from eight others, 0 to 256 each. Each word of `one` fills all lanes.
inline void hamming_256_of_eight(const EightWords* one, const EightWords* others, EightWords& distances) {
  const auto ones_of_nibbles = [&](std::size_t word, EightWords& sum) {
    EightWords v = others[word] ^ one[word];
    v -= (v >> 1) & 0x55555555U;
    sum += (v & 0x33333333U) + ((v >> 2) & 0x33333333U);
  };
  // At most 12 in each of four bits, and 64 in each byte.
  EightWords first{}, second{}, third{};
  for (std::size_t word = 0; word < 3; ++word) ones_of_nibbles(word, first);
  for (std::size_t word = 3; word < 6; ++word) ones_of_nibbles(word, second);
  for (std::size_t word = 6; word < 8; ++word) ones_of_nibbles(word, third);
  const EightWords bytes = ((first & 0x0F0F0F0FU) + ((first >> 4) & 0x0F0F0F0FU)) +
                           ((second & 0x0F0F0F0FU) + ((second >> 4) & 0x0F0F0F0FU)) +
                           ((third & 0x0F0F0F0FU) + ((third >> 4) & 0x0F0F0F0FU));
  const EightWords halves = (bytes & 0x00FF00FFU) + ((bytes >> 8) & 0x00FF00FFU);
  distances = (halves & 0xFFFFU) + (halves >> 16);
}

}  // namespace ilp
