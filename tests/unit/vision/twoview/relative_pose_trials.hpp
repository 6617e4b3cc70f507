// Any number of trials of the kinds that relative_pose_synthetic holds four of each, and the bars to reach on them.
#pragma once

#include <iterator>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "tests/unit/vision/twoview/relative_pose_data.hpp"

namespace ilp::test {

/// One kind of pair: camera f = 700 px, 640x480, at height 1, 80 % overlap or forward motion; 500 matches.
struct TrialCell {
  int scene;     ///< index into scene_kinds, as in the names of the files
  int outliers;  ///< per cent: uniform positions in image b
  int noise;     ///< tenths of a pixel, one sigma, both images
};

struct SceneKind {
  const char* name;
  double relief;  ///< depths lie in 1 +- relief
  bool smooth;    ///< waves of hills; else every point has a depth of its own
  bool turns;     ///< rotation vector uniform in +-4 degrees an axis; else none, and the track is straight
  bool forward;
};
inline constexpr SceneKind scene_kinds[] = {
    {"general", 0.25, false, true, false},         {"plane", 0, true, true, false},
    {"relief 2 %", 0.02, true, true, false},       {"line over plane", 0, true, false, false},
    {"line over relief", 0.1, true, false, false}, {"forward", 0.1, true, true, true},
};

/// Median errors in degrees that PoseLib's 5-point LO-RANSAC reaches over 60 trials (README of
/// relative_pose_synthetic; threshold 2 sigma).
struct PeerBar {
  TrialCell cell;
  double rotation, direction;
};
inline constexpr PeerBar poselib_bars[] = {
    {{0, 30, 5}, 0.086, 0.20}, {{0, 50, 10}, 0.19, 0.43}, {{1, 30, 5}, 0.15, 0.52}, {{1, 50, 5}, 0.21, 0.81},
    {{3, 30, 10}, 0.32, 1.45}, {{4, 30, 5}, 0.13, 0.47},  {{2, 30, 5}, 0.15, 0.50}, {{5, 30, 5}, 0.23, 1.57},
};

inline const PeerBar* poselib_bar(const TrialCell& cell) {
  for (const PeerBar& bar : poselib_bars) {
    if (bar.cell.scene == cell.scene && bar.cell.outliers == cell.outliers && bar.cell.noise == cell.noise) return &bar;
  }
  return nullptr;
}

inline double trial_gaussian(Rng& rng) {
  const double u = 1 - rng.uniform();
  return std::sqrt(-2 * det_log(u)) * det_cos(2 * 3.14159265358979323846 * rng.uniform());
}

inline Vec3 in_box(Rng& rng, double x, double y, double z) {
  const double u = 2 * rng.uniform() - 1;
  const double v = 2 * rng.uniform() - 1;
  const double w = 2 * rng.uniform() - 1;
  return {x * u, y * v, z * w};
}

inline Vec2 pixel_of(const CameraModel& camera, const Vec3& point) {
  return {camera.fx * point.x() / point.z() + camera.cx, camera.fy * point.y() / point.z() + camera.cy};
}

inline bool inside(const CameraModel& camera, const Vec2& pixel) {
  return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < camera.width && pixel.y() < camera.height;
}

/// Heights in -1 .. 1 over the plane at distance 1: four waves, 0.2 to 0.45 long, as the variograms of the files have
/// it.
class Hills {
 public:
  explicit Hills(Rng& rng) {
    for (Wave& wave : waves_) {
      const double direction = 2 * 3.14159265358979323846 * rng.uniform();
      const double number = 2 * 3.14159265358979323846 / (0.2 + 0.25 * rng.uniform());
      wave = {number * det_cos(direction), number * det_sin(direction), 2 * 3.14159265358979323846 * rng.uniform()};
    }
  }

  [[nodiscard]] double height(double x, double y) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += det_sin(wave.kx * x + wave.ky * y + wave.phase);
    return sum / static_cast<double>(std::size(waves_));
  }

 private:
  struct Wave {
    double kx, ky, phase;
  };
  Wave waves_[4];
};

inline PoseCase make_trial(const TrialCell& cell, std::uint64_t trial) {
  constexpr std::size_t matches = 500;
  const SceneKind& kind = scene_kinds[cell.scene];
  Rng rng(mix64(trial) ^ mix64(static_cast<std::uint64_t>(1000 * cell.scene + cell.outliers)), 5);
  PoseCase result{.name = kind.name};
  CameraModel& camera = result.camera;
  camera.width = 640;
  camera.height = 480;
  camera.fx = camera.fy = 700;
  camera.cx = 319.5;
  camera.cy = 239.5;

  const double four_degrees = 4 / degrees;
  const double baseline = 0.2 * camera.width / camera.fx;
  Vec3 centre(baseline, 0, 0);
  if (kind.turns) {
    result.truth.rotation = rotation_from_vector(in_box(rng, four_degrees, four_degrees, four_degrees));
    centre += in_box(rng, 0, 0.055, 0.04);
  }
  if (kind.forward) centre = Vec3(0.02, 0.01, 0.15);
  result.truth.translation = -(result.truth.rotation * centre);

  const Hills hills(rng);
  const double sigma = 0.1 * cell.noise;
  const std::size_t outliers = matches * static_cast<std::size_t>(cell.outliers) / 100;
  while (result.pairs.size() < matches) {
    const double x = (rng.uniform() * camera.width - camera.cx) / camera.fx;
    const double y = (rng.uniform() * camera.height - camera.cy) / camera.fy;
    const double depth = 1 - kind.relief * (kind.smooth ? hills.height(x, y) : 2 * rng.uniform() - 1);
    const Vec3 point = kind.smooth ? Vec3(x, y, depth) : Vec3(depth * x, depth * y, depth);
    const Vec2 a = pixel_of(camera, point);
    Vec2 b = pixel_of(camera, result.truth * point);
    if (!inside(camera, a) || !inside(camera, b)) continue;
    const bool outlier = result.pairs.size() < outliers;
    if (outlier) {
      b.x() = rng.uniform() * camera.width;
      b.y() = rng.uniform() * camera.height;
    }
    const double noise[4] = {trial_gaussian(rng), trial_gaussian(rng), trial_gaussian(rng), trial_gaussian(rng)};
    static_cast<void>(result.pairs.push_back(
        {a.x() + sigma * noise[0], a.y() + sigma * noise[1], b.x() + sigma * noise[2], b.y() + sigma * noise[3], 0}));
    result.inlier.push_back(outlier ? 0 : 1);
  }
  result.truth.translation.normalize();
  return result;
}

}  // namespace ilp::test
