#include "fsw/vision/stereo/depth/normalised_row.hpp"

#include <algorithm>

#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

void normalised_row(const CameraModel& camera, std::int32_t y, double* x_out, double* y_out) {
  constexpr std::int32_t anchor_step = 4;
  Vec2 anchor = normalised_from_pixel(camera, Vec2(0, y));
  for (std::int32_t first = 0; first < camera.width; first += anchor_step) {
    const Vec2 next = normalised_from_pixel(camera, Vec2(first + anchor_step, y));
    const Vec2 step = (next - anchor) / anchor_step;
    const std::int32_t end = std::min(first + anchor_step, camera.width);
    for (std::int32_t x = first; x < end; ++x) {
      x_out[x] = anchor.x() + (x - first) * step.x();
      y_out[x] = anchor.y() + (x - first) * step.y();
    }
    anchor = next;
  }
}

}  // namespace ilp
