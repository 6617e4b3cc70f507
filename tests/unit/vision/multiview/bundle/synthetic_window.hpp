// Windows with known truth: cameras over gently rolling ground, all looking down.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp::test {

struct WindowScene {
  int cameras = 5;
  int fixed = 2;  ///< the first ones
  int points = 400;
  double noise_px = 0.5;
  double height = 10;
  double step = 2.5;  ///< between cameras
  double relief = 1;
  unsigned seed = 1;
};

inline RigidTransform looking_down(const Vec3& centre, const Vec3& tilt) {
  RigidTransform pose{.rotation = rotation_from_vector(tilt) * Vec3(1, -1, -1).asDiagonal()};
  pose.translation = -(pose.rotation * centre);
  return pose;
}

/// The true window; every camera has its own intrinsics, and each point is seen where it falls inside 640x480.
inline void make_window(const WindowScene& scene, BundleProblem& truth) {
  truth = {};
  std::mt19937 random(scene.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, scene.noise_px > 0 ? scene.noise_px : 1);
  for (int i = 0; i < scene.cameras; ++i) {
    BundleCamera camera;
    const Vec3 tilt = 0.05 * Vec3(uniform(random), uniform(random), 3 * uniform(random));
    camera.pose = pose_from(
        looking_down(Vec3(i * scene.step, 0.3 * uniform(random), scene.height + 0.3 * uniform(random)), tilt));
    camera.fx = 700 + 10 * i;
    camera.fy = 705 - 5 * i;
    camera.cx = 320 + i;
    camera.cy = 240 - i;
    camera.fixed = i < scene.fixed;
    (void)truth.cameras.push_back(camera);
  }
  while (truth.points.size() < static_cast<std::size_t>(scene.points)) {
    const Vec3 x((scene.cameras - 1) * scene.step * 0.5 * (1 + 1.8 * uniform(random)), 4 * uniform(random),
                 scene.relief * uniform(random));
    BundleObservation seen[limits::max_bundle_cameras];
    int count = 0;
    for (int i = 0; i < scene.cameras; ++i) {
      const BundleCamera& camera = truth.cameras[static_cast<std::size_t>(i)];
      const Vec3 c = cam_from_world(camera.pose) * x;
      const double u = camera.fx * c.x() / c.z() + camera.cx;
      const double v = camera.fy * c.y() / c.z() + camera.cy;
      if (c.z() <= 0 || u < 0 || v < 0 || u > 639 || v > 479) continue;
      const double du = scene.noise_px > 0 ? noise(random) : 0;
      const double dv = scene.noise_px > 0 ? noise(random) : 0;
      seen[count++] = {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(truth.points.size()), u + du, v + dv};
    }
    if (count < 2) continue;
    (void)truth.points.push_back({{x.x(), x.y(), x.z()}});
    for (int k = 0; k < count; ++k) (void)truth.observations.push_back(seen[k]);
  }
}

/// Moves free cameras and all points by about `pixels` in the images.
inline void disturb(BundleProblem& problem, double pixels, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, 1);
  const double angle = pixels / 700;
  for (BundleCamera& camera : problem.cameras) {
    if (camera.fixed) continue;
    RigidTransform pose = cam_from_world(camera.pose);
    const Vec3 centre(camera.pose.centre[0], camera.pose.centre[1], camera.pose.centre[2]);
    pose.rotation = rotation_from_vector(angle * Vec3(normal(random), normal(random), normal(random))) * pose.rotation;
    const Vec3 moved = centre + 10 * angle * Vec3(normal(random), normal(random), normal(random));
    pose.translation = -(pose.rotation * moved);
    camera.pose = pose_from(pose);
  }
  for (BundlePoint& point : problem.points) {
    for (double& x : point.position) x += 5 * angle * normal(random);
  }
}

}  // namespace ilp::test
