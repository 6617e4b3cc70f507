// Resamples real images to rectified ones. One bilinear interpolation includes rotation or polar map, and distortion.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

enum class Side : std::uint8_t { left, right };

/// Resamples rows y_begin .. y_end - 1 of the rectified image of one side. `valid` is 255 if all four source pixels lie
/// inside the image, else 0. Outside the image, pixels take the grey value of the nearest border pixel, so that windows
/// at the border contain no false edge. Coordinates and weights are rounded to 1/256 px. Returns `invalid_argument` if
/// the source does not have the size of the camera, if the output does not have the size of the pair or exceeds the
/// limits, or if the rows are outside.
Status resample_rows(const RectifiedPair& pair, Side side, const CameraModel& camera, GrayView source,
                     std::int32_t y_begin, std::int32_t y_end, const MutableGrayView& rectified,
                     const ImageView<std::uint8_t>& valid);

}  // namespace ilp
