// Decides which of the surfaces around a depth edge each pixel beside the edge belongs to.
//
// A window that reaches across a depth edge takes the disparity of the surface with the stronger texture, most often
// the nearer one, or finds none. Each pixel beside an edge is therefore matched again, only at the disparities around
// it. The pixels near it that look like it, in the left image and in the right one, are compared with their
// counterparts. They form a support of any shape that ends where the surface ends; the weights of both images are
// multiplied (K.-J. Yoon, I. S. Kweon, "Adaptive Support-Weight Approach for Correspondence Search", IEEE Trans.
// Pattern Analysis 28(4), 2006). A right pixel shows only one surface: if two surfaces claim it, the one whose
// counterparts differ less keeps it.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Radius of a pixel's surroundings, px.
inline constexpr std::int32_t edge_reach = 4;
inline constexpr std::int32_t edge_rows = 2 * edge_reach + 1;

struct EdgeWorkspace {
  template <typename T>
  using Row = std::array<T, static_cast<std::size_t>(limits::max_rectified_width)>;
  /// Disparities in quarters of a pixel, with edge_reach empty pixels on either side.
  using QuarterRow =
      std::array<std::int16_t, static_cast<std::size_t>(limits::max_rectified_width) + std::size_t{2} * edge_reach>;

  std::array<QuarterRow, edge_rows> rows;  ///< ring of the latest rows
  Row<std::int16_t> lowest, highest;       ///< range of the disparities around each pixel
  /// Mean grey difference, left minus right, by tile of the current band, in quarters of a grey level.
  std::array<std::int32_t, static_cast<std::size_t>(max_search_tiles)> brightness;
  Row<float> difference;  ///< mean difference of the pixel's counterparts; negative if no edge is near
  /// Per right pixel: difference and disparity of the left pixel that differs least from it.
  Row<float> right_difference;
  Row<std::int16_t> right_quarters;
};

/// Takes in row `y` of the map and decides row `y - edge_reach`. It must be called in the order y = 0 .. height - 1 +
/// edge_reach. Larger disparities are nearer.
/// - A pixel with a disparity is decided if disparities around it differ from its own by more than
///   `params.surface_step_px`. It takes one of these if the counterparts then differ less by at least twice the sensor
///   noise, or six times for a nearer surface.
/// - A pixel without a disparity is decided if there are two surfaces around it. It takes the disparity of one if its
///   counterparts are alike there and differ more on the other by at least twice the noise.
/// - If counterparts at a disparity `params.surface_step_px` lower or higher are more alike than at the chosen one, the
///   pixel becomes empty instead.
/// A chosen disparity is of the kind `resolved`, with an error of 0.4 px. If the choice is suspect, the error is 0.6 of
/// the distance to the farthest other surface. A choice is suspect if counterparts differ, if a window found another
/// disparity, or if most of the surroundings are on other surfaces. Decided rows are part of the surroundings of the
/// next ones. Of `rows`, only sizes, masks and images are read.
void decide_edges_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                      EdgeWorkspace& workspace);

}  // namespace ilp
