// Gives samples outside the region values that cost no bytes: a smooth continuation of those inside.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Replaces the samples outside `mask` (0) by means of those inside over ever larger squares, interpolated (a pyramid
/// pulled up and pushed down; Gortler et al., "The Lumigraph", SIGGRAPH 1996). Without a step at the region's border
/// its wavelet coefficients are small. Nothing changes where the mask is empty or full. |sample| < 2^26. `scratch`
/// holds limits::max_image_pixels samples.
void fill_background(ImageView<std::int32_t> samples, MaskView mask, std::int32_t* scratch);

}  // namespace ilp
