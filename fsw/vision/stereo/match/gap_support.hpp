// Gives disparities to gaps that the ground around them supports and the images do not contradict.
//
// A window of weak texture, or one that reaches across an edge of brightness, finds no peak of its own. If matches on
// two opposite sides of a gap agree, the plane through them is tried. The pixels of the gap that are about as bright as
// the pixel in question must correlate with their counterparts more than noise does. They are a support of any shape,
// after the adaptive weights of K.-J. Yoon, I. S. Kweon, "Adaptive Support-Weight Approach for Correspondence Search",
// IEEE Trans. Pattern Analysis 28(4), 2006, with weights of 0 or 1. If the images contradict most of a gap (liquid,
// shadow, sky), the whole gap is rejected, including its rim.
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

/// The gap along one line of pixels that runs down the image, between the matches above and below it.
struct GapLine {
  std::int16_t next = 0;  ///< row below the newest gap pixel
  bool closed = false;    ///< there are matches at both ends, in rows `above` and `below`
  std::int16_t above = 0, below = 0;
};
struct GapWorkspace {
  static constexpr std::size_t lines = limits::max_rectified_width + limits::max_rectified_height;
  /// Lines straight down, down to the right, and down to the left.
  std::array<std::array<GapLine, lines>, 3> down;
  std::int32_t proposals = 0;
};

/// Clears the workspace before the first row.
void begin_gaps(GapWorkspace& workspace);

/// Proposes disparities for the gap pixels of row `y`: those of the kind `none` inside the left mask. Proposals get the
/// kind `supported`. The map must be complete except for proposals, and rows must come in order. Of `rows`, only sizes,
/// masks and images are read.
void propose_gap_row(const NccRows& rows, const StereoParams& params, std::int32_t y, const DisparityView& map,
                     GapWorkspace& workspace);

/// Joins the gap pixels of row `y` to their left and upper neighbours in the same gap. Rows must come in order, after
/// their proposals.
void connect_gap_row(MaskView left_valid, const DisparityView& map, std::int32_t y, PixelForest& workspace);

/// Withdraws the proposals of row `y` whose gap has too few of them: less than 15 % of its pixels, plus a few for
/// chance. Call it after all rows are connected.
void accept_gap_row(const DisparityView& map, std::int32_t y, PixelForest& workspace);

}  // namespace ilp
