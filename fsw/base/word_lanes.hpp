// Vectors of 16-bit words and of 32-bit sums of their products, in the widths of vector_width.hpp. All results are
// integers and the same for every width.
#pragma once

#include <cstdint>
#include <cstring>

#include "fsw/base/vector_width.hpp"

namespace ilp {

template <typename Width>
struct WordLanes;

template <>
struct WordLanes<KnownWidth<VectorWidth::bytes16>> {
  using Words [[gnu::vector_size(16)]] = std::int16_t;
  using Sums [[gnu::vector_size(16)]] = std::int32_t;
  using UnsignedWords [[gnu::vector_size(16)]] = std::uint16_t;
  using UnsignedSums [[gnu::vector_size(16)]] = std::uint32_t;
  static constexpr std::int32_t word_count = 8, sum_count = 4;

  /// sums[i] += p[2 i] * q[2 i] + p[2 i + 1] * q[2 i + 1]
  [[gnu::always_inline]] static void add_products(const Words& p, const Words& q, Sums& sums) {
#if defined(__SSE2__)
    // GCC does not find this instruction by itself.
    using Halves [[gnu::vector_size(16)]] = short;  // NOLINT(google-runtime-int)
    sums += reinterpret_cast<Sums>(
        __builtin_ia32_pmaddwd128(reinterpret_cast<const Halves&>(p), reinterpret_cast<const Halves&>(q)));
#else
    const Sums both_p = reinterpret_cast<Sums>(p), both_q = reinterpret_cast<Sums>(q);
    sums += ((both_p << 16) >> 16) * ((both_q << 16) >> 16) + (both_p >> 16) * (both_q >> 16);
#endif
  }
  /// words[i] = from[at[i]]
  static void gather(const std::uint32_t* from, const Sums& at, Sums& words) {
    const auto load = [&](int i) { return static_cast<std::int32_t>(from[static_cast<std::uint32_t>(at[i])]); };
    words = Sums{load(0), load(1), load(2), load(3)};
  }
  /// Element i of the result is the sum of the elements of the i-th vector.
  static Sums sums_of_four(const Sums& p, const Sums& q, const Sums& r, const Sums& s) {
    const Sums pq = __builtin_shufflevector(p, q, 0, 4, 1, 5) + __builtin_shufflevector(p, q, 2, 6, 3, 7);
    const Sums rs = __builtin_shufflevector(r, s, 0, 4, 1, 5) + __builtin_shufflevector(r, s, 2, 6, 3, 7);
    return __builtin_shufflevector(pq, rs, 0, 1, 4, 5) + __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
  }
  static std::int32_t sum_of(const Sums& p) {
    return p[0] + p[1] + p[2] + p[3];
  }
};

#if defined(__x86_64__)
template <>
struct WordLanes<KnownWidth<VectorWidth::bytes32>> {
  using Half = WordLanes<KnownWidth<VectorWidth::bytes16>>;
  using Words [[gnu::vector_size(32)]] = std::int16_t;
  using Sums [[gnu::vector_size(32)]] = std::int32_t;
  using UnsignedWords [[gnu::vector_size(32)]] = std::uint16_t;
  using UnsignedSums [[gnu::vector_size(32)]] = std::uint32_t;
  static constexpr std::int32_t word_count = 16, sum_count = 8;

  [[gnu::target("avx2")]] static void add_products(const Words& p, const Words& q, Sums& sums) {
    using Halves [[gnu::vector_size(32)]] = short;  // NOLINT(google-runtime-int)
    sums += reinterpret_cast<Sums>(
        __builtin_ia32_pmaddwd256(reinterpret_cast<const Halves&>(p), reinterpret_cast<const Halves&>(q)));
  }
  [[gnu::target("avx2")]] static void gather(const std::uint32_t* from, const Sums& at, Sums& words) {
    const auto load = [&](int i) { return static_cast<std::int32_t>(from[static_cast<std::uint32_t>(at[i])]); };
    words = Sums{load(0), load(1), load(2), load(3), load(4), load(5), load(6), load(7)};
  }
  [[gnu::target("avx2")]] static Half::Sums sums_of_four(const Sums& p, const Sums& q, const Sums& r, const Sums& s) {
    Sums pq, rs;
    add_two(p, q, pq);
    add_two(r, s, rs);
    const Sums all = __builtin_shufflevector(pq, rs, 0, 1, 8, 9, 4, 5, 12, 13) +
                     __builtin_shufflevector(pq, rs, 2, 3, 10, 11, 6, 7, 14, 15);
    return fold(all);
  }
  [[gnu::target("avx2")]] static std::int32_t sum_of(const Sums& p) { return Half::sum_of(fold(p)); }

 private:
  // As for 16 bytes, in both halves at once.
  [[gnu::target("avx2")]] static void add_two(const Sums& p, const Sums& q, Sums& sums) {
    sums = __builtin_shufflevector(p, q, 0, 8, 1, 9, 4, 12, 5, 13) +
           __builtin_shufflevector(p, q, 2, 10, 3, 11, 6, 14, 7, 15);
  }
  [[gnu::target("avx2")]] static Half::Sums fold(const Sums& p) {
    return __builtin_shufflevector(p, p, 0, 1, 2, 3) + __builtin_shufflevector(p, p, 4, 5, 6, 7);
  }
};
#endif

/// Loads a vector from `from`, which need not be aligned.
template <typename Vector, typename Element>
void load_lanes(const Element* from, Vector& v) {
  std::memcpy(&v, from, sizeof v);
}

}  // namespace ilp
