// Pixels without a disparity are measured again at the disparity of their neighbours.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"
#include "fsw/vision/stereo/stereo_params.hpp"

namespace ilp {

/// Measures invalid pixels of row `y` (sigma 0) at which `params.recovery_neighbours` of the eight neighbours agree
/// within 1 px of their median. The correlation of the window there must reach `recovery_min_ncc` and be no less than
/// one disparity further on either side, its peak must lie within `recovery_step_px` of the median, and the window must
/// have texture. A recovered disparity is a measurement with an error of its own, not an interpolation. The function
/// works in place, so that a recovered pixel is a neighbour of the next one. The rows y - 1 and y + 1 must be complete
/// except for their own recovery. Only sizes, masks, images and damping of `rows` are read; `range` is that of the
/// search.
void recover_row(const NccRows& rows, const DisparityRange& range, const StereoParams& params, std::int32_t y,
                 const ImageView<float>& disparity_px, const ImageView<float>& sigma_px);

}  // namespace ilp
