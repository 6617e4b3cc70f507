// Pixels without a disparity are measured again at the disparity of their neighbours.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Recovers invalid pixels (sigma 0) of row `y`. A pixel is tried if at least `params.recovery_neighbours` of its eight
/// neighbours agree within 1 px of their median. Its disparity is accepted if the window has texture, its correlation
/// reaches `recovery_min_ncc` and is no lower than one disparity to either side, and its peak lies within
/// `recovery_step_px` of the median. A recovered disparity is a measurement with an error of its own, not an
/// interpolation. The function works in place, so that a recovered pixel is a neighbour of the next one. Rows y - 1 and
/// y + 1 must be complete except for their own recovery. Of `rows`, only sizes, masks, images and damping are read.
/// `range` is the searched range.
void recover_row(const NccRows& rows, const DisparityRange& range, const StereoParams& params, std::int32_t y,
                 const ImageView<float>& disparity_px, const ImageView<float>& sigma_px);

}  // namespace ilp
