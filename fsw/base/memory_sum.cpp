#include "fsw/base/memory_sum.hpp"

#include <array>
#include <cstring>

#include "fsw/base/checksum.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

/// Four words; the compiler takes what the processor has for them.
using Words = std::uint64_t __attribute__((vector_size(32)));
/// Below it the end of the sums takes longer than a checksum.
constexpr std::size_t few_bytes = 512;

/// For each lane the sum of its words and the sum of these sums, as in J. Fletcher, "An arithmetic checksum for serial
/// transmissions", 1982, with words of 64 bits: two changes that leave the first as it is differ in the second, unless
/// both are in the highest bits. So the same is done with the halves of each word exchanged.
struct Sums {
  Words word{}, of_word{}, turned{}, of_turned{};

  void add(const std::byte* at) {
    Words words;
    std::memcpy(&words, at, sizeof(words));
    word += words;
    of_word += word;
    // GCC does not find this instruction by itself.
    using Halves = std::uint32_t __attribute__((vector_size(32)));
    const auto halves = reinterpret_cast<Halves>(words);
    turned += reinterpret_cast<Words>(__builtin_shufflevector(halves, halves, 1, 0, 3, 2, 5, 4, 7, 6));
    of_turned += turned;
  }
};
/// Two of them do not wait for each other.
using TwoSums = std::array<Sums, 2>;
constexpr std::size_t row_bytes = 2 * sizeof(Words);

void add_rows(std::span<const std::byte> bytes, TwoSums& sums) {
  Sums first, second;
#pragma GCC unroll 4
  for (std::size_t at = 0; at + row_bytes <= bytes.size(); at += row_bytes) {
    first.add(bytes.data() + at);
    second.add(bytes.data() + at + sizeof(Words));
  }
  sums = {first, second};
}

}  // namespace

std::uint64_t memory_sum64(std::span<const std::byte> bytes, std::uint64_t before) {
  if (bytes.size() < few_bytes) return checksum64(bytes, before);
  TwoSums sums;
  with_widest_vectors([&] { add_rows(bytes, sums); });
  return checksum64(bytes.last(bytes.size() % row_bytes), checksum64(memory_of(sums), before));
}

}  // namespace ilp
