// Selects the sub-pixel disparity of every pixel of a row from its aggregated costs, and estimates its error or rejects
// it.
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
  /// Per left pixel: the first and the last disparity index whose two neighbouring indices were searched, too.
  std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width)> first_inner, last_inner;
  /// Per left pixel: correlations before, at and after the winner, summed over the pixels of its support, and the
  /// number of these. All are 0 for a rejected pixel.
  alignas(64) std::array<std::int32_t, std::size_t{4} * limits::max_rectified_width> fits;
  /// Per left pixel: its own three correlations, and one element without a meaning.
  alignas(64) std::array<std::int16_t, std::size_t{4} * limits::max_rectified_width> peaks;
};

/// Selects the disparities of row `y`. Every pixel takes its cheapest disparity. The disparity is rejected if its
/// aggregated cost is not unique, if it fails the left-right check, if the window has no texture, or if the mean
/// correlation over the support of the fit is too low. The left-right check: if several left pixels chose the same
/// right pixel, it keeps the cheapest of them and those within one disparity of the cheapest. A quadratic fit gives the
/// fraction of a pixel and `sigma_px` (correlation_peak.hpp); sigma 0 means invalid. `rows.search` says which
/// disparities the row searched; `count` is the number of disparities of the whole range. `ncc` must have one
/// additional element at either end, of any value.
void select_row(const NccRows& rows, std::int32_t y, std::int32_t count, const StereoParams& params,
                const std::int16_t* ncc, const RowWinner* winners, const float* variance, SelectionWorkspace& workspace,
                float* disparity_px, float* sigma_px);

}  // namespace ilp
