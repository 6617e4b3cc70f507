// Pixels beside depth edges choose between the surfaces around them.
//
// A window that reaches over a depth edge takes the disparity of the surface with the stronger texture, most often of
// the nearer one, or finds none. Each pixel beside an edge is therefore asked again, at the disparities around it only.
// The pixels near it that look like it, in the left image and in the right one, are compared with their counterparts:
// a support of any shape that ends where the surface ends, with the weights of both images multiplied (K.-J. Yoon,
// I. S. Kweon, "Adaptive Support-Weight Approach for Correspondence Search", IEEE Trans. Pattern Analysis 28(4), 2006).
// A right pixel shows one surface only: of two that claim it, the one whose counterparts differ less keeps it.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Distance at which a pixel's surroundings are looked at, px.
inline constexpr std::int32_t edge_reach = 4;
inline constexpr std::int32_t edge_rows = 2 * edge_reach + 1;

struct EdgeWorkspace {
  template <typename T>
  using Row = std::array<T, static_cast<std::size_t>(limits::max_rectified_width)>;
  /// Disparities in quarters of a pixel, with edge_reach empty pixels on either side.
  using QuarterRow =
      std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * edge_reach>;

  std::array<QuarterRow, edge_rows> rows;  ///< the latest ones
  Row<std::int16_t> lowest, highest;       ///< disparity around each pixel
  /// Mean difference of the grey values of both images, by tile of the band at work, quarters of a grey level.
  std::array<std::int32_t, static_cast<std::size_t>(max_search_tiles)> brightness;
  Row<float> difference;  ///< of a pixel's counterparts; negative where there is no edge to doubt it
  /// Per right pixel: the left pixel that differs least from it.
  Row<float> right_difference;
  Row<std::int16_t> right_quarters;
};

/// Takes in row `y` of the map and decides row `y - edge_reach`, for y = 0 .. height - 1 + edge_reach in order. A pixel
/// whose disparity differs by more than `params.surface_step_px` from those around it takes one of theirs if its
/// counterparts there differ less by twice the noise of the sensor, six times for a nearer surface. A pixel without a
/// disparity takes one of two surfaces around it if its counterparts are alike there, and differ more in the other by
/// twice the noise. What would be taken is left empty if counterparts `params.surface_step_px` away on either side are
/// more alike. What is taken over is resolved, with an error of 0.4 px, or of 0.6 of the distance to the farthest other
/// surface where the choice is suspect: counterparts differ, a window found another disparity, or the surroundings are
/// mostly on other surfaces. Decided rows are part of the surroundings of the next ones. Larger
/// disparities are nearer. Of `rows` only sizes, masks and images are read.
void decide_edges_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                      EdgeWorkspace& workspace);

}  // namespace ilp
