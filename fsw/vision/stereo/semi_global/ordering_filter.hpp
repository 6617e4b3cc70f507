// Applies the ordering constraint (paper 3.3): along a scanline, points appear in the same order in both images.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

struct OrderingWorkspace {
  using Row = std::array<std::uint16_t, static_cast<std::size_t>(limits::max_rectified_width)>;
  /// For each chain length, the chain whose last right column is smallest: this column, and its left column + 1.
  Row last_right, last_left;
  /// Per left column: the previous left column of its chain + 1; 0 at the beginning of the chain.
  Row previous;
};

/// Keeps the largest set of the row's matches (sigma > 0) whose right columns, rounded to whole pixels, do not decrease
/// from left to right, and sets sigma of the others to 0. One pass of dynamic programming (C. Schensted, "Longest
/// Increasing and Decreasing Subsequences", 1961), at most width * log(width) steps.
void keep_ordered_row(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace);

}  // namespace ilp
