// Terrain given by a formula and seen through a distorting camera by casting rays: depth is exact at every pixel.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {

/// World z of the ground at (x, y).
using Terrain = std::function<double(double, double)>;

struct View {
  CameraModel camera;
  RigidTransform cam_from_world;
  Image image;
  std::vector<double> depth;  ///< along the optical axis
};

inline CameraModel distorting_camera(std::int32_t width = 320, std::int32_t height = 240) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = 0.95 * width;
  camera.fy = 0.96 * width;
  camera.cx = 0.5 * width - 3.2;
  camera.cy = 0.5 * height + 2.7;
  camera.k1 = -0.14;
  camera.k2 = 0.05;
  camera.p1 = 0.0011;
  camera.p2 = -0.0008;
  return camera;
}

/// Camera at `centre` looking straight down with x to the world's +x, then turned by the rotation vector `turn` (camera
/// frame).
inline RigidTransform looking_down(const Vec3& centre, const Vec3& turn = Vec3::Zero()) {
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  RigidTransform t{.rotation = rotation_from_vector(turn) * down};
  t.translation = -(t.rotation * centre);
  return t;
}

inline Vec3 centre_of(const RigidTransform& cam_from_world) {
  return -(cam_from_world.rotation.transpose() * cam_from_world.translation);
}

/// Where the ray of a pixel meets the ground; terrain must be gentle against the ray.
inline Vec3 ground_point(const CameraModel& camera, const RigidTransform& cam_from_world, const Terrain& terrain,
                         double u, double v) {
  const Vec2 n = normalised_from_pixel(camera, Vec2(u, v));
  const Vec3 direction = cam_from_world.rotation.transpose() * Vec3(n.x(), n.y(), 1);
  const Vec3 centre = centre_of(cam_from_world);
  Vec3 point = centre - centre.z() / direction.z() * direction;
  for (int i = 0; i < 60; ++i) {
    const double t = (terrain(point.x(), point.y()) - centre.z()) / direction.z();
    point = centre + t * direction;
  }
  return point;
}

/// `texture_px_per_unit` scales the ground's pattern; noise in grey levels (standard deviation).
inline View render_view(const CameraModel& camera, const RigidTransform& cam_from_world, const Terrain& terrain,
                        double texture_px_per_unit, double noise, std::uint64_t seed) {
  View view{camera, cam_from_world, Image(camera.width, camera.height), {}};
  Rng rng(seed);
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec3 ground = ground_point(camera, cam_from_world, terrain, x, y);
      const double pattern = fractal_texture(texture_px_per_unit * ground.x(), texture_px_per_unit * ground.y(), 3, 11);
      double gaussian = -6;
      for (int k = 0; k < 12; ++k) gaussian += rng.uniform();
      const double grey = 128 + 2 * (pattern - 128) + noise * gaussian;
      view.image.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0));
      view.depth.push_back((cam_from_world * ground).z());
    }
  }
  return view;
}

/// Pixel of a world point in the real image; may lie outside.
inline Vec2 pixel_of(const CameraModel& camera, const RigidTransform& cam_from_world, const Vec3& world) {
  const Vec3 p = cam_from_world * world;
  return pixel_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z()));
}

inline bool inside(const CameraModel& camera, const Vec2& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1;
}

}  // namespace ilp::test
