#include "fsw/vision/stereo/ordered/row_lanes.hpp"

namespace ilp {
namespace {

using lanes::I16;
using lanes::U32;
using lanes::U64;

constexpr int cost_shift = 5;
static_assert(ncc_one >> cost_shift == max_ordered_cost);

[[gnu::always_inline]] inline I16 cost_of(I16 ncc, I16 unknown_discount) {
  const I16 positive = ncc > 0 ? ncc : I16{};
  return ((ncc_one - positive) >> cost_shift) - ((ncc == 0) & unknown_discount);
}

[[gnu::always_inline]] inline I16 low_words(I16 a, I16 b) {
  return __builtin_shufflevector(a, b, 0, 8, 1, 9, 2, 10, 3, 11);
}
[[gnu::always_inline]] inline I16 high_words(I16 a, I16 b) {
  return __builtin_shufflevector(a, b, 4, 12, 5, 13, 6, 14, 7, 15);
}
[[gnu::always_inline]] inline I16 low_pairs(I16 a, I16 b) {
  return reinterpret_cast<I16>(__builtin_shufflevector(reinterpret_cast<U32>(a), reinterpret_cast<U32>(b), 0, 4, 1, 5));
}
[[gnu::always_inline]] inline I16 high_pairs(I16 a, I16 b) {
  return reinterpret_cast<I16>(__builtin_shufflevector(reinterpret_cast<U32>(a), reinterpret_cast<U32>(b), 2, 6, 3, 7));
}
[[gnu::always_inline]] inline I16 low_halves(I16 a, I16 b) {
  return reinterpret_cast<I16>(__builtin_shufflevector(reinterpret_cast<U64>(a), reinterpret_cast<U64>(b), 0, 2));
}
[[gnu::always_inline]] inline I16 high_halves(I16 a, I16 b) {
  return reinterpret_cast<I16>(__builtin_shufflevector(reinterpret_cast<U64>(a), reinterpret_cast<U64>(b), 1, 3));
}

/// Rows and columns of an 8 x 8 matrix change places.
[[gnu::always_inline]] inline void transpose(const I16 (&r)[row_lanes], RowLanes* out) {
  const I16 a = low_words(r[0], r[1]), b = high_words(r[0], r[1]), c = low_words(r[2], r[3]),
            d = high_words(r[2], r[3]), e = low_words(r[4], r[5]), f = high_words(r[4], r[5]),
            g = low_words(r[6], r[7]), h = high_words(r[6], r[7]);
  const I16 ac = low_pairs(a, c), ac2 = high_pairs(a, c), bd = low_pairs(b, d), bd2 = high_pairs(b, d),
            eg = low_pairs(e, g), eg2 = high_pairs(e, g), fh = low_pairs(f, h), fh2 = high_pairs(f, h);
  out[0] = low_halves(ac, eg);
  out[1] = high_halves(ac, eg);
  out[2] = low_halves(ac2, eg2);
  out[3] = high_halves(ac2, eg2);
  out[4] = low_halves(bd, fh);
  out[5] = high_halves(bd, fh);
  out[6] = low_halves(bd2, fh2);
  out[7] = high_halves(bd2, fh2);
}

}  // namespace

void load_costs(const std::int16_t* const* ncc, std::ptrdiff_t entry, std::int32_t count, std::int16_t unknown,
                RowLanes* out) {
  const I16 discount = I16{} + static_cast<std::int16_t>(max_ordered_cost - unknown);
  for (std::int32_t d = 0; d < count; d += row_lanes) {
    I16 rows[row_lanes];
    for (std::int32_t k = 0; k < row_lanes; ++k) rows[k] = cost_of(lanes::load<I16>(ncc[k] + entry + d), discount);
    transpose(rows, out + d);
  }
}

}  // namespace ilp
