// Vertical distances between matching points of a rectified pair. They show whether the poses that rectified the pair
// fit its images.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"

namespace ilp {

/// Histogram of the absolute vertical distances between matches, over all panels of a pair.
struct VerticalResidual {
  static constexpr int bins_per_px = 16;
  static constexpr int max_px = 3;  ///< largest searched distance; a match beyond it counts as this distance
  std::array<std::uint32_t, static_cast<std::size_t>(bins_per_px) * max_px + 1> histogram{};
  std::uint32_t count = 0;

  /// Returns the median of the absolute distances, rectified px; 0 if there are none.
  [[nodiscard]] double median_px() const;
};

/// Largest median with which the poses fit: it is below 0.3 px if the poses fit and, as for chance matches, above 1 px
/// with a wrong pose. The second value is the least number of matches for this decision.
inline constexpr double max_vertical_residual_px = 0.8;
inline constexpr std::uint32_t min_vertical_residuals = 40;

/// Adds the residuals of one panel. Every eighth pixel of every eighth row is used if it is matched and has structure
/// along its column. A window of 7x7 px of the left image is correlated with the right image at the pixel's disparity,
/// up to max_px above and below; the residual is the vertex of the parabola through the best correlation. All views
/// must have the same size.
void add_vertical_residuals(GrayView left, GrayView right, MaskView right_valid, const DisparityView& map,
                            VerticalResidual& residual);

}  // namespace ilp
