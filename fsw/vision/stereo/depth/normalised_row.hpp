// The viewing directions of a row of real pixels, by interpolation.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp {

/// Normalised coordinates (X/Z, Y/Z) of pixels (0, y) .. (camera.width - 1, y). Distortion is removed exactly at every
/// fourth pixel and linearly between, which is off by less than 0.01 px for any lens in use.
void normalised_row(const CameraModel& camera, std::int32_t y, double* x_out, double* y_out);

}  // namespace ilp
