// The speed of the ground in the image.
#pragma once

#include <cmath>

#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// Upper bound of the mean speed of the image's points, px/s: the speed of a corner if shift, rotation and change of
/// scale move it in the same direction. `later_from_first` is the image's motion in the time `between`, which is
/// positive.
[[nodiscard]] inline double apparent_speed_px_s(const Similarity2& later_from_first, std::int32_t width,
                                                std::int32_t height, TimeNs between) {
  const double half_width = 0.5 * width, half_height = 0.5 * height;
  const double corner = std::sqrt(half_width * half_width + half_height * half_height);
  const Similarity2& s = later_from_first;
  const double shift = std::sqrt(s.shift_x_px * s.shift_x_px + s.shift_y_px * s.shift_y_px);
  const double moved = shift + corner * (std::fabs(s.rotation_rad) + std::fabs(s.scale - 1));
  return moved * static_cast<double>(ns_per_s) / static_cast<double>(between);
}

}  // namespace ilp
