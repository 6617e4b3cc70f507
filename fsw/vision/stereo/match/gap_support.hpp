// Disparities for gaps that the ground around them supports, where the images do not contradict.
//
// A window of weak texture, or one that reaches over an edge of brightness, finds no peak of its own. Where matches on
// two opposite sides agree, their plane is tried: the pixels of the gap that are as bright as the one in question must
// correlate with their counterparts, more than noise does. They are a support of any shape, after the adaptive weights
// of K.-J. Yoon, I. S. Kweon, "Adaptive Support-Weight Approach for Correspondence Search", IEEE Trans. Pattern
// Analysis 28(4), 2006, which are 0 or 1 here. A gap of which most cannot be seen again (liquid, shadow, sky) is
// contradicted as a whole, its rim included.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_map.hpp"
#include "fsw/vision/stereo/match/pixel_forest.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// The gap along one line of pixels down the image: where its matches begin again above and below.
struct GapLine {
  std::int16_t next = 0;  ///< row below the newest gap pixel
  bool closed = false;    ///< there are matches at both ends, in the rows `above` and `below`
  std::int16_t above = 0, below = 0;
};
struct GapWorkspace {
  static constexpr std::size_t lines = limits::max_rectified_width + limits::max_rectified_height;
  /// Straight down, down to the right, down to the left.
  std::array<std::array<GapLine, lines>, 3> down;
  std::int32_t proposals = 0;
};

/// Before the first row.
void begin_gaps(GapWorkspace& workspace);

/// Proposes disparities for the gaps of row `y`: pixels of the kind `none` inside the left mask. Proposals are of the
/// kind `supported`. The map must be complete but for them; rows come in order. Only sizes, masks and images of `rows`
/// are read.
void propose_gap_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                     GapWorkspace& workspace);

/// Joins the gap pixels of row `y` to their left and upper neighbours. Rows come in order, after their proposals.
void connect_gap_row(MaskView left_valid, const DisparityView& map, std::int32_t y, PixelForest& workspace);

/// After all rows are connected: takes the proposals of row `y` back where fewer of their gap have one than
/// 15 %, and a few by chance.
void accept_gap_row(const DisparityView& map, std::int32_t y, PixelForest& workspace);

}  // namespace ilp
