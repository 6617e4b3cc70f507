// A second look at pixels that were left without an answer: is the disparity of their neighbours theirs too?
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"
#include "fsw/vision/stereo/match/ncc_cost.hpp"
#include "fsw/vision/stereo/match/stereo_params.hpp"

namespace ilp {

/// Invalid pixels of row `y` (sigma 0) at which `params.recovery_neighbours` of the eight neighbours agree within 1 px
/// of their median are measured there: the correlation of the window, computed again, must reach `recovery_min_ncc` and
/// be no less than one disparity further on either side, its place must be within `recovery_step_px` of the median, and
/// the window must have texture. What is found is a
/// measurement with an error of its own, not an interpolation. In place, so that recovered pixels are neighbours of the
/// next. The rows y - 1 and y + 1 must be complete but for their own recovery. Only sizes, masks, images and damping of
/// `rows` are read; `range` is that of the search.
void recover_row(const NccRows& rows, const DisparityRange& range, const StereoParams& params, std::int32_t y,
                 const ImageView<float>& disparity_px, const ImageView<float>& sigma_px);

}  // namespace ilp
