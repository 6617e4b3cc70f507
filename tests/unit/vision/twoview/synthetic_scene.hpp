// Two views of made-up terrain with known motion: the truth of the two-view tests.
#pragma once

#include <cmath>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp::test {

enum class Motion { sideways, line, forward, rotation_only };

struct SceneOptions {
  Motion motion = Motion::sideways;
  double relief = 0.25;    ///< depth 1 +- relief at random; 0 is a plane
  bool on_a_line = false;  ///< all points on one straight line in space
  int matches = 300;
  double outlier_share = 0;          ///< matches whose point in image b is anywhere
  double noise_px = 0;               ///< one sigma, each coordinate of both images
  double baseline = 0.18;            ///< in units of the depth
  bool informative_quality = false;  ///< outliers have a lower quality on average
  std::uint64_t seed = 1;
};

struct Scene {
  CameraModel camera_a, camera_b;
  RigidTransform b_from_a;   ///< truth; |t| = 1, or zero for rotation_only
  PointPairs pairs;          ///< ideal px
  std::vector<Vec3> points;  ///< in frame a, |t| = 1; of outliers too
  std::vector<bool> inlier;
};

inline double gaussian(Rng& rng) {
  const double u = 1 - rng.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * 3.14159265358979 * rng.uniform());
}

inline double symmetric(Rng& rng, double bound) {
  return bound * (2 * rng.uniform() - 1);
}

inline CameraModel make_camera(double fx, double fy, double cx, double cy) {
  CameraModel camera{640, 480, fx, fy, cx, cy};
  return camera;
}

inline RigidTransform make_motion(const SceneOptions& options, Rng& rng) {
  const bool turns = options.motion != Motion::line;
  RigidTransform motion;
  const Vec3 turn(symmetric(rng, 0.06), symmetric(rng, 0.06), symmetric(rng, 0.15));
  if (turns) motion.rotation = rotation_from_vector(turn);
  Vec3 centre = Vec3::Zero();  // of camera b in frame a
  switch (options.motion) {
    case Motion::sideways:
      centre = Vec3(1, symmetric(rng, 0.5), symmetric(rng, 0.2));
      break;
    case Motion::line:
      centre = Vec3(1, 0, 0);
      break;
    case Motion::forward:
      centre = Vec3(symmetric(rng, 0.1), symmetric(rng, 0.1), 1);
      break;
    case Motion::rotation_only:
      return motion;
  }
  motion.translation = -(motion.rotation * centre.normalized());
  return motion;
}

/// Points are seen by both cameras; depths are in units of the altitude, then scaled so that the baseline is 1.
inline Scene make_scene(const SceneOptions& options) {
  Rng rng(options.seed, 77);
  Scene scene;
  scene.camera_a = make_camera(700, 690, 321, 238);
  scene.camera_b = make_camera(720, 715, 315, 243);
  scene.b_from_a = make_motion(options, rng);
  const CameraModel& ca = scene.camera_a;
  const CameraModel& cb = scene.camera_b;
  while (static_cast<int>(scene.points.size()) < options.matches) {
    double ua = rng.uniform() * ca.width;
    double va = rng.uniform() * ca.height;
    if (options.on_a_line) va = 100 + 0.4 * ua;
    const double depth = (1 + symmetric(rng, options.relief)) / options.baseline;
    const Vec3 point = depth * Vec3((ua - ca.cx) / ca.fx, (va - ca.cy) / ca.fy, 1);
    const Vec3 seen = scene.b_from_a * point;
    if (seen.z() < 0.1) continue;
    double ub = cb.fx * seen.x() / seen.z() + cb.cx;
    double vb = cb.fy * seen.y() / seen.z() + cb.cy;
    if (ub < 0 || vb < 0 || ub >= cb.width || vb >= cb.height) continue;
    const bool outlier = rng.uniform() < options.outlier_share;
    if (outlier) {
      ub = rng.uniform() * cb.width;
      vb = rng.uniform() * cb.height;
    }
    ua += options.noise_px * gaussian(rng);
    va += options.noise_px * gaussian(rng);
    ub += options.noise_px * gaussian(rng);
    vb += options.noise_px * gaussian(rng);
    double quality = 0;
    if (options.informative_quality) quality = rng.uniform() + (outlier ? 0 : 0.4);
    static_cast<void>(scene.pairs.push_back({ua, va, ub, vb, static_cast<float>(quality)}));
    scene.points.push_back(point);
    scene.inlier.push_back(!outlier);
  }
  return scene;
}

}  // namespace ilp::test
