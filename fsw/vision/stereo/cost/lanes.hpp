// Operations on sixteen bytes with the vector types of GCC and Clang, which give the same values on every processor.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "fsw/base/word_lanes.hpp"

namespace ilp::lanes {

using U8 [[gnu::vector_size(16)]] = std::uint8_t;
using I16 [[gnu::vector_size(16)]] = std::int16_t;
using U16 [[gnu::vector_size(16)]] = std::uint16_t;
using I32 [[gnu::vector_size(16)]] = std::int32_t;
using U32 [[gnu::vector_size(16)]] = std::uint32_t;
using U64 [[gnu::vector_size(16)]] = std::uint64_t;

inline constexpr std::int32_t bytes = 16;
inline constexpr std::int32_t words = 8;

template <typename V>
[[nodiscard, gnu::always_inline]] inline V load(const void* from) {
  V v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
template <typename V>
[[gnu::always_inline]] inline void store(void* to, V v) {
  std::memcpy(to, &v, sizeof v);
}
template <typename V>
[[nodiscard, gnu::always_inline]] inline V lower(V a, V b) {
  return a < b ? a : b;
}

// Functions that take the even and the odd bytes of a word rely on this.
static_assert(std::endian::native == std::endian::little);

/// Converts the words of both vectors to bytes; all of them must be 0 to 255.
[[nodiscard, gnu::always_inline]] inline U8 bytes_of_words(I16 first, I16 second) {
#if defined(__SSE2__)
  // GCC does not find this instruction by itself.
  return reinterpret_cast<U8>(__builtin_ia32_packuswb128(first, second));
#else
  return __builtin_shufflevector(reinterpret_cast<U8>(first), reinterpret_cast<U8>(second), 0, 2, 4, 6, 8, 10, 12, 14,
                                 16, 18, 20, 22, 24, 26, 28, 30);
#endif
}

/// Loads eight bytes as words.
[[nodiscard, gnu::always_inline]] inline I16 words_at(const std::uint8_t* from) {
  using Bytes [[gnu::vector_size(8)]] = std::uint8_t;
  return __builtin_convertvector(load<Bytes>(from), I16);
}

/// Narrows the elements of both vectors to words. They must be masks, or values that fit a word.
[[nodiscard, gnu::always_inline]] inline I16 words_of(I32 first, I32 second) {
#if defined(__SSE2__)
  return reinterpret_cast<I16>(__builtin_ia32_packssdw128(first, second));
#else
  return __builtin_shufflevector(reinterpret_cast<I16>(first), reinterpret_cast<I16>(second), 0, 2, 4, 6, 8, 10, 12,
                                 14);
#endif
}

/// Multiplies word by word and adds the two products of each pair of neighbouring words.
[[nodiscard, gnu::always_inline]] inline I32 products_of(I16 a, I16 b) {
  I32 sums{};
  WordLanes<KnownWidth<VectorWidth::bytes16>>::add_products(a, b, sums);
  return sums;
}

/// Repeats the four bytes of quarter `Quarter` over the whole vector.
template <int Quarter>
[[nodiscard, gnu::always_inline]] inline U8 spread(U8 v) {
  const auto quarters = reinterpret_cast<U32>(v);
  return reinterpret_cast<U8>(__builtin_shufflevector(quarters, quarters, Quarter, Quarter, Quarter, Quarter));
}

/// Sets every byte to the lowest byte of the vector.
[[nodiscard, gnu::always_inline]] inline U8 lowest_everywhere(U8 v) {
  const auto halves = reinterpret_cast<U32>(v);
  v = lower(v, reinterpret_cast<U8>(__builtin_shufflevector(halves, halves, 2, 3, 0, 1)));
  const auto quarters = reinterpret_cast<U32>(v);
  v = lower(v, reinterpret_cast<U8>(__builtin_shufflevector(quarters, quarters, 1, 0, 3, 2)));
  // The four quarters are equal now.
  v = __builtin_shufflevector(v, v, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
  const auto pairs = reinterpret_cast<U32>(v);
  v = lower(v, reinterpret_cast<U8>(__builtin_shufflevector(pairs, pairs, 1, 0, 3, 2)));
  const auto words_of = reinterpret_cast<U16>(v);
  return lower(v, reinterpret_cast<U8>(__builtin_shufflevector(words_of, words_of, 1, 0, 3, 2, 5, 4, 7, 6)));
}

[[nodiscard, gnu::always_inline]] inline std::int16_t lowest_word(I16 v) {
  v = lower(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  v = lower(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
  v = lower(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6));
  return v[0];
}
/// Returns true if any bit is set.
[[nodiscard, gnu::always_inline]] inline bool any(I16 v) {
  const auto halves = reinterpret_cast<U64>(v);
  return (halves[0] | halves[1]) != 0;
}

}  // namespace ilp::lanes
