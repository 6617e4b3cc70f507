// The cheapest ordered path through the matches of a scanline (paper 3.3), for eight scanlines at a time.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/cost/row_winner.hpp"
#include "fsw/vision/stereo/ordered/row_lanes.hpp"

namespace ilp {

struct OrderedWorkspace {
  /// Guards around a column are too expensive for any path.
  using Column = std::array<RowLanes, static_cast<std::size_t>(max_padded_disparities) + 2>;

  /// By column and searched disparity, with one more below: the cheapest path from the left to the point before the
  /// column, relative to the lowest there.
  std::array<RowLanes, max_cost_entries + static_cast<std::size_t>(limits::max_rectified_width)> before;
  Column reached;  ///< by disparity: the cheapest path to the point between two columns
  Column cost;     ///< of the matches of a column
  Column total;    ///< the cheapest path through each match of a column
};

/// Cost of a pixel without a match, of max_matching_cost: two make a chance match.
inline constexpr int occlusion_cost = 24;

/// Finds for each of `lanes` rows (1 to row_lanes) the path with the lowest cost through the grid of left and right
/// pixels. Each step of a path matches the next pixels of both images, or declares the next pixel of one of them
/// occluded, which costs `occlusion_cost`. So no path breaks the order or uses a pixel twice, and both images
/// have the same part in it. `ncc[row]` is that of compute_ncc_row over the disparities of `search`.
/// `winners[row][x].unique` is true where left pixel x is matched, and any path that matches it elsewhere, by more than
/// one disparity, costs at least `params.uniqueness_permille` of max_ordered_cost more for each column of a window.
///
/// I. Cox et al., "A Maximum Likelihood Stereo Algorithm", CVIU 63(3), 1996; G. Van Meerbergen et al., "A Hierarchical
/// Symmetric Stereo Algorithm Using Dynamic Programming", IJCV 47(1), 2002.
void find_ordered_rows(const SearchRow& search, std::int32_t padded, const StereoParams& params,
                       const std::int16_t* const* ncc, std::int32_t lanes, OrderedWorkspace& workspace,
                       RowWinner* const* winners);

}  // namespace ilp
