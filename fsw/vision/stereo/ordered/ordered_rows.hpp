// Finds the cheapest ordered path through the matches of a scanline (paper 3.3), for eight scanlines at a time.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/cost/row_winner.hpp"
#include "fsw/vision/stereo/ordered/row_lanes.hpp"

namespace ilp {

struct OrderedWorkspace {
  /// One element per disparity, with a guard before and after them that is too expensive for any path.
  using Column = std::array<RowLanes, static_cast<std::size_t>(max_padded_disparities) + 2>;

  /// Cost of the cheapest path from the left to the point before a column, relative to the lowest one of the column: by
  /// column and searched disparity, with one more element below them.
  std::array<RowLanes, max_cost_entries + static_cast<std::size_t>(limits::max_rectified_width)> before;
  Column reached;  ///< by disparity: cost of the cheapest path to the point between two columns
  Column cost;     ///< costs of the matches of a column
  Column total;    ///< cost of the cheapest path through each match of a column
};

/// Cost of a pixel without a match, in units of which max_matching_cost is a correlation of 0. Two such pixels cost as
/// much as a chance match.
inline constexpr int occlusion_cost = 24;

/// Finds, for each of `lanes` rows (1 to row_lanes), the cheapest path through the grid of left and right pixels. Each
/// step of a path either matches the next pixels of both images, or declares the next pixel of one image occluded,
/// which costs `occlusion_cost`. So a path preserves the order and uses each pixel once, and it treats both images
/// alike. `ncc[row]` are the correlations of compute_ncc_row for the disparities of `search`. `winners[row][x].unique`
/// is true if left pixel x is matched and every path that matches it at a disparity differing by more than one costs
/// more, by at least `params.uniqueness_permille` of max_ordered_cost for each column of a window.
///
/// I. Cox et al., "A Maximum Likelihood Stereo Algorithm", CVIU 63(3), 1996; G. Van Meerbergen et al., "A Hierarchical
/// Symmetric Stereo Algorithm Using Dynamic Programming", IJCV 47(1), 2002.
void find_ordered_rows(const SearchRow& search, std::int32_t padded, const StereoParams& params,
                       const std::int16_t* const* ncc, std::int32_t lanes, OrderedWorkspace& workspace,
                       RowWinner* const* winners);

}  // namespace ilp
