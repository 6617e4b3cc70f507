#include "sim/ground/map/pixel_rays.hpp"

namespace ilp::map {
const host::Raster<Ray>& PixelRays::of(const CameraModel& camera) {
  if (!rays_.empty() && camera == camera_) return rays_;
  camera_ = camera;
  rays_ = host::Raster<Ray>(camera.width, camera.height);
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec2 n = normalised_from_pixel(camera, Vec2(x, y));
      rays_.at(x, y) = {static_cast<float>(n.x()), static_cast<float>(n.y())};
    }
  }
  return rays_;
}

}  // namespace ilp::map
