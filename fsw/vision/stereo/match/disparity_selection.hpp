// Selects sub-pixel disparities from the aggregated costs of a row, each with its error or rejected.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/cost/row_winner.hpp"

namespace ilp {

struct SelectionWorkspace {
  /// Per right pixel: the lowest cost with which a left pixel chose it, and its disparity.
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width) + max_padded_disparities> right_best,
      right_index;
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width)> best_index;
  /// Per left pixel: the indices that were searched with one more on either side.
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width)> first_inner, last_inner;
  /// Per left pixel: correlations before, at and after the winner, summed over the pixels of its support, and the
  /// number of these. All are 0 for a rejected pixel.
  alignas(64) std::array<std::int32_t, std::size_t{4} * limits::max_rectified_width> fits;
  /// Per left pixel: its own, and one without a meaning.
  alignas(64) std::array<std::int16_t, std::size_t{4} * limits::max_rectified_width> peaks;
};

/// Every pixel takes its cheapest disparity. The disparity is rejected if its aggregated cost is not unique, if it
/// fails the left-right check, if the window has no texture, or if the mean correlation of the fit's support is too
/// low. The left-right check: of the left pixels that chose one right pixel, the cheapest keeps it, and so do those
/// within one disparity of that one. A quadratic fit gives the part of a pixel and `sigma_px` (correlation_peak.hpp); 0
/// = invalid. Row `y` is searched as `rows.search` says, `count` disparities in all. `ncc` has an element more at
/// either end, of any value.
void select_row(const NccRows& rows, std::int32_t y, std::int32_t count, const StereoParams& params,
                const std::int16_t* ncc, const RowWinner* winners, const float* variance, SelectionWorkspace& workspace,
                float* disparity_px, float* sigma_px);

}  // namespace ilp
