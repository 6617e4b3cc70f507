#include "fsw/base/checksum.hpp"

#include "fsw/base/rng.hpp"

namespace ilp {
namespace {

constexpr std::size_t word_bytes = 8;
constexpr std::size_t lanes = 4;  // independent of one another, so that the processor works on all of them at once

std::uint64_t word_at(const std::byte* bytes) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, word_bytes);
  return word;
}

/// One to one in `word` for every `sum`, and in `sum` for every `word`: a difference is never lost on the way.
std::uint64_t mixed(std::uint64_t sum, std::uint64_t word) {
  const std::uint64_t product = (sum ^ word) * 0x9E3779B185EBCA87ULL;
  return product ^ product >> 32U;  // high bits move nothing but themselves in a product
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
