// Averages sub-pixel disparities over a small neighbourhood, preserving slopes and steps, and estimates the error of
// the average.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"

namespace ilp {

inline constexpr std::int32_t smoothing_radius = 2;
inline constexpr std::int32_t smoothing_rows = 2 * smoothing_radius + 1;

struct SmoothingWorkspace {
  /// The latest rows before averaging. Invalid pixels have a value that is far from every disparity.
  std::array<
      std::array<float, static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * smoothing_radius>,
      smoothing_rows>
      rows;
  std::array<float, static_cast<std::size_t>(limits::max_rectified_width)> sum, count, scatter;
};

/// Takes in row `y` of the map and averages row `y - smoothing_radius`. It must be called in the order y = 0 .. height
/// - 1 + smoothing_radius. Neighbours enter in pairs on opposite sides of the centre; a pair counts only if both are
/// valid and within `max_step_px` of the centre. On a plane the mean of a pair is the true value at the centre; at a
/// step the pair drops out. Valid pixels stay valid, invalid ones invalid.
///
/// On input the error is that of a single window (peak_sigma). On output it is the error of the average: averaging
/// reduces the error of the windows, and three terms are added, from the scatter of the neighbours, from the number of
/// neighbours that disagree (an edge is near), and from the slope of the ground. The error of a resolved pixel is not
/// changed: it is the error of the choice between two surfaces, which the neighbourhood does not reduce.
void smooth_row(const DisparityView& map, std::int32_t y, float max_step_px, SmoothingWorkspace& workspace);

}  // namespace ilp
