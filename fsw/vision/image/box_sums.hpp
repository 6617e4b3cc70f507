// Sums over axis-aligned boxes by an integral image (F. Crow, "Summed-area tables for texture mapping", 1984).
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Computes the integral image: sums(x, y) is the sum of all values at columns < x and rows < y. `sums` is one column
/// wider and one row higher than `values`. `Sum` must be able to hold the sum of the whole image.
template <typename Value, typename Sum>
void integrate(ImageView<const Value> values, ImageView<Sum> sums) {
  for (std::int32_t x = 0; x <= values.width; ++x) sums.at(x, 0) = 0;
  for (std::int32_t y = 0; y < values.height; ++y) {
    const Value* const in = values.row(y);
    const Sum* const above = sums.row(y);
    Sum* const out = sums.row(y + 1);
    Sum row = 0;
    out[0] = 0;
    for (std::int32_t x = 0; x < values.width; ++x) {
      row += static_cast<Sum>(in[x]);
      out[x + 1] = above[x + 1] + row;
    }
  }
}

/// Returns the sum of the values at columns x0 <= x < x1 and rows y0 <= y < y1 from the integral image `sums`.
template <typename Sum>
[[nodiscard]] Sum box_sum(ImageView<Sum> sums, std::int32_t x0, std::int32_t y0, std::int32_t x1, std::int32_t y1) {
  return sums.at(x1, y1) - sums.at(x0, y1) - sums.at(x1, y0) + sums.at(x0, y0);
}

}  // namespace ilp
