// Bilinear interpolation in fixed point, which gives the same value on every machine.
#pragma once

#include <cmath>
#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// A pixel coordinate with 16 fractional bits.
using FixedCoordinate = std::int32_t;

[[nodiscard]] inline FixedCoordinate to_fixed(double x) {
  return static_cast<FixedCoordinate>(std::floor(x * 65536.0 + 0.5));
}

/// Returns the interpolated grey value at (x, y), rounded to nearest. The caller ensures 0 <= x < width - 1 and 0 <= y
/// < height - 1.
[[nodiscard]] inline std::uint8_t sample_bilinear(GrayView image, FixedCoordinate x, FixedCoordinate y) {
  const std::uint8_t* const upper = image.row(y >> 16) + (x >> 16);
  const std::uint8_t* const lower = upper + image.stride;
  const std::int32_t fx = (x >> 8) & 255;
  const std::int32_t fy = (y >> 8) & 255;
  const std::int32_t top = (upper[0] << 8) + fx * (upper[1] - upper[0]);
  const std::int32_t bottom = (lower[0] << 8) + fx * (lower[1] - lower[0]);
  const std::int32_t value = (top << 8) + fy * (bottom - top);
  return static_cast<std::uint8_t>((value + (1 << 15)) >> 16);
}

}  // namespace ilp
