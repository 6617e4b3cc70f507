// The viewing directions of a row of real pixels, by interpolation.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp {

/// Normalised coordinates (X/Z, Y/Z) of the `count` pixels from (first, y) on; `first` is a multiple of four.
/// Distortion is removed exactly at every fourth pixel and linearly between, which is off by less than 0.01 px for any
/// lens in use.
void normalised_row(const CameraModel& camera, std::int32_t y, std::int32_t first, std::int32_t count, double* x_out,
                    double* y_out);

}  // namespace ilp
