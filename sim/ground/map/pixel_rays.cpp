#include "sim/ground/map/pixel_rays.hpp"

namespace ilp::map {
namespace {

bool same(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2;
}

}  // namespace

const host::Raster<Ray>& PixelRays::of(const CameraModel& camera) {
  if (!rays_.empty() && same(camera, camera_)) return rays_;
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
