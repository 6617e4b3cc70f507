#include "fsw/base/checksum.hpp"

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

constexpr std::size_t word_bytes = 8;
constexpr std::size_t lanes = 4;  // independent of each other, so that the processor computes them in parallel

std::uint64_t word_at(const std::byte* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, word_bytes);
  return word;
}

/// A bijection of `word` for every `sum`, and of `sum` for every `word`, so that a difference is never lost.
std::uint64_t mixed(std::uint64_t sum, std::uint64_t word) {
  const std::uint64_t product = (sum ^ word) * 0x9E3779B185EBCA87ULL;
  return product ^ product >> 32U;  // high bits of a factor affect only the high bits of a product
}

}  // namespace

std::uint64_t checksum64(std::span<const std::byte> bytes, std::uint64_t before) {
  std::uint64_t sums[lanes] = {before, before + 1, before + 2, before + 3};
  const std::byte* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= lanes * word_bytes; left -= lanes * word_bytes, at += lanes * word_bytes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) sums[lane] = mixed(sums[lane], word_at(at + lane * word_bytes));
  }
  std::uint64_t sum = bytes.size();
  for (const std::uint64_t lane : sums) sum = mixed(sum, lane);
  for (; left >= word_bytes; left -= word_bytes, at += word_bytes) sum = mixed(sum, word_at(at));
  std::uint64_t rest = 0;
  if (left > 0) std::memcpy(&rest, at, left);
  return mix64(mixed(sum, rest));
}

}  // namespace ilp
