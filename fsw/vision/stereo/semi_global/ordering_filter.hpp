// The ordering constraint (paper 3.3): along a scanline, points appear in the same order in both images.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

struct OrderingWorkspace {
  using Row = std::array<std::uint16_t, static_cast<std::size_t>(limits::max_rectified_width)>;
  /// Of the chains of each length, the one with the smallest last right column: this column, and the left column + 1.
  Row last_right, last_left;
  /// Per left column: the left column + 1 before it in its chain, 0 at the beginning.
  Row previous;
};

/// Keeps the largest set of the row's matches (sigma > 0) whose right columns, rounded to whole pixels, do not decrease
/// from left to right, and sets sigma of the others to 0. One pass of dynamic programming (C. Schensted, "Longest
/// Increasing and Decreasing Subsequences", 1961), at most width * log(width) steps.
void keep_ordered_row(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace);

}  // namespace ilp
