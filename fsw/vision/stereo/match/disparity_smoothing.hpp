// Averages sub-pixel disparities over a small neighbourhood, with slopes and steps preserved, and gives their error.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"

namespace ilp {

inline constexpr std::int32_t smoothing_radius = 2;
inline constexpr std::int32_t smoothing_rows = 2 * smoothing_radius + 1;

struct SmoothingWorkspace {
  /// The latest rows before averaging, invalid pixels far away from every disparity.
  std::array<
      std::array<float, static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * smoothing_radius>,
      smoothing_rows>
      rows;
  std::array<float, static_cast<std::size_t>(limits::max_rectified_width)> sum, count, scatter;
};

/// Takes in row `y` of the map and averages row `y - smoothing_radius`, for y = 0 .. height - 1 + smoothing_radius in
/// order. Neighbours enter in pairs on opposite sides, both valid and within `max_step_px` of the centre: on a plane
/// their mean is the centre's true value, at a step they drop out. Valid pixels stay valid, invalid ones invalid.
///
/// On input the error is that of each window alone (peak_sigma). On output it is the error of the average: the error of
/// the windows counts less, and the neighbourhood adds to it by the scatter of the neighbours, by the number of those
/// that disagree (an edge is near), and by the slope of the ground. That of a resolved pixel stays as it is: it is that
/// of the choice between two surfaces, of which the neighbourhood says no more.
void smooth_row(const DisparityView& map, std::int32_t y, float max_step_px, SmoothingWorkspace& workspace);

}  // namespace ilp
