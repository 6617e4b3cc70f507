// Viewing directions of a row of real (distorted) pixels, by interpolation.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp {

/// Computes the normalised coordinates (X/Z, Y/Z) of `count` pixels from (first, y) to the right; `first` must be a
/// multiple of four. Distortion is removed exactly at every fourth pixel and interpolated linearly between them, with
/// an error below 0.01 px for any lens in use.
void normalised_row(const CameraModel& camera, std::int32_t y, std::int32_t first, std::int32_t count, double* x_out,
                    double* y_out);

}  // namespace ilp
