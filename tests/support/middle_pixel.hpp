// The inverse of seen_pixel(): where a point seen at a pixel would be seen at the time of the image's middle row.
#pragma once

#include "fsw/vision/geometry/rolling_shutter.hpp"

namespace ilp::test {

inline Vec2 middle_pixel(const CameraModel& camera, const ImageMotion& motion, const Vec2& seen) {
  return pixel_from_normalised(camera,
                               moved_back(motion, row_time_s(camera, seen.y()), normalised_from_pixel(camera, seen)));
}

}  // namespace ilp::test
