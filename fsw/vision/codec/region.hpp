// Region of interest by way of the wavelet coefficients: from an image and its mask to the pre-image that makes an
// ordinary reversible encoder code the region first, or nothing but the region (see jpeg2000.hpp).
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

/// `samples` (signed, about zero) becomes the pre-image, in place; `mask` the region's coefficients. `shift` is 0 where
/// there is nothing to tell apart. coefficient_overflow when a scaled coefficient would need more than 25 bits.
Status apply_region(ImageView<std::int32_t> samples, ImageView<std::uint8_t> mask, int wavelet_levels,
                    RegionCoding coding, int region_resolutions, std::int32_t* scratch, std::uint8_t* mask_scratch,
                    int& shift);

}  // namespace ilp
