// The ordering constraint (paper 3.3): along a scanline, points appear in the same order in both images.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

struct OrderingWorkspace {
  /// Columns that a match may have in the right image: one image width to either side of it.
  static constexpr std::int32_t columns = 3 * limits::max_rectified_width;
  /// Prefix maxima over right columns (P. Fenwick, "A New Data Structure for Cumulative Frequency Tables", 1994) of
  /// chain length << 16 | left column + 1.
  std::array<std::uint32_t, static_cast<std::size_t>(columns) + 1> longest;
  /// Per left column: the left column + 1 before it in its chain, 0 at the beginning.
  std::array<std::uint16_t, static_cast<std::size_t>(limits::max_rectified_width)> previous;
};

/// Keeps the largest set of the row's matches (sigma > 0) whose right columns, rounded to whole pixels, do not decrease
/// from left to right, and sets sigma of the others to 0. One pass of dynamic programming, width * log(columns) steps.
void keep_ordered_row(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace);

}  // namespace ilp
