// How far matching points are from sharing a row. It shows whether the poses that rectified a pair fit its images.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"

namespace ilp {

/// Vertical distances between matches, counted over the panels of a pair.
struct VerticalResidual {
  static constexpr int bins_per_px = 16;
  static constexpr int max_px = 3;  ///< farthest searched; a match beyond it counts as this
  std::array<std::uint32_t, static_cast<std::size_t>(bins_per_px) * max_px + 1> histogram{};
  std::uint32_t count = 0;

  /// Median of the absolute distances, rectified px; 0 when there is none.
  [[nodiscard]] double median_px() const;
};

/// The median is below 0.3 px if the poses fit. With a wrong pose it is above 1 px, as for chance matches.
inline constexpr double max_vertical_residual_px = 0.8;
inline constexpr std::uint32_t min_vertical_residuals = 40;

/// Takes every eighth pixel of every eighth row that is matched and has structure along the column.
/// Correlates a window of 7x7 px of the left image with the right one at the disparity, up to max_px above and below,
/// and takes the vertex of the parabola through the best. All views have the same size.
void add_vertical_residuals(GrayView left, GrayView right, MaskView right_valid, const DisparityView& map,
                            VerticalResidual& residual);

}  // namespace ilp
