// Fills the samples outside a region with a smooth continuation of those inside, which costs few bytes to code.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Replaces the samples outside `mask` (0) by means of the samples inside, taken over ever larger squares and
/// interpolated (a pull-push pyramid; Gortler et al., "The Lumigraph", SIGGRAPH 1996). There is no step at the region's
/// border, so the wavelet coefficients are small. Nothing changes if the mask is empty or full. Samples must satisfy
/// |sample| < 2^26. `scratch` holds limits::max_image_pixels samples.
void fill_background(ImageView<std::int32_t> samples, MaskView mask, std::int32_t* scratch);

}  // namespace ilp
