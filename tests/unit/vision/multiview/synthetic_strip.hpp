// Strips with known truth: corners and matches of a balloon's keyframes over analytic ground, no images.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <unordered_map>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/feature_types.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::test {

struct StripScene {
  int keyframes = 30;
  double relief = 0.1;       ///< peak to peak / flying height
  double yaw_per_frame = 0;  ///< rad
  double climb = 0;          ///< height gained over the strip / height at the start
  double tilt = 0.03;        ///< standard deviation of the swing, rad
  double overlap = 0.82;     ///< of consecutive images
  double noise_px = 0.3;
  double tails = 0;    ///< share of corners with ten times this noise
  double wrong = 0.1;  ///< share of matches that join different corners
  double walk_px = 0;  ///< standard deviation by which a corner leaves its point from image to image, as it does where
                       ///< each image is matched to the previous one
  double moving = 0;   ///< share of ground points that move: shadows, clouds
  double moving_x = 0, moving_y = 0;  ///< their step from image to image / height
  int corners = 600;                  ///< in an image
  unsigned seed = 1;
};

struct StripKeyframe {
  RigidTransform truth;  ///< cam_from_world
  Corners corners;
  Matches matches;  ///< to the previous keyframe
};

struct SyntheticStrip {
  CameraModel camera{640, 480, 700, 702, 322, 238, -0.08, 0.02, 0.0005, -0.0003};
  std::vector<StripKeyframe> keyframes;

  [[nodiscard]] static double ground(double x, double y, double relief) {
    return 0.25 * relief * (std::sin(3.1 * x + 0.5) * std::cos(2.3 * y) + std::sin(7.7 * x - 4.9 * y));
  }

  explicit SyntheticStrip(const StripScene& scene) {
    std::mt19937 random(scene.seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::normal_distribution<double> normal(0, 1);
    std::vector<Vec3> ground_points;
    const double step = (1 - scene.overlap) * camera.width / camera.fx;
    const double reach = 1.2 * (1 + scene.climb);
    const double length = step * scene.keyframes;
    const double density = scene.corners * (camera.fx / camera.width) * (camera.fy / camera.height);
    // A turning strip curls up: ground all around is needed then.
    const double side = scene.yaw_per_frame != 0 ? length + reach : reach;
    const auto count = static_cast<int>(density * (length + 2 * reach) * 2 * side);
    for (int i = 0; i < count; ++i) {
      const double x = 0.5 * length + (0.5 * length + reach) * uniform(random);
      const double y = side * uniform(random);
      ground_points.emplace_back(x, y, ground(x, y, scene.relief));
    }
    std::unordered_map<std::size_t, std::uint16_t> previous;
    off_point_.assign(ground_points.size(), Vec2::Zero());
    const auto moving = static_cast<std::size_t>(scene.moving * static_cast<double>(ground_points.size()));
    for (int k = 0; k < scene.keyframes; ++k) {
      const double height = 1 + scene.climb * k / scene.keyframes;
      const Vec3 centre(k * step, 0.02 * normal(random), height + 0.01 * normal(random));
      const Vec3 swing(scene.tilt * normal(random), scene.tilt * normal(random), scene.yaw_per_frame * k);
      keyframes.emplace_back();
      StripKeyframe& frame = keyframes.back();
      frame.truth.rotation = rotation_from_vector(swing) * Vec3(1, -1, -1).asDiagonal();
      frame.truth.translation = -(frame.truth.rotation * centre);
      previous = observe(scene, ground_points, previous, random, frame);
      for (std::size_t i = 0; i < moving; ++i) ground_points[i] += Vec3(scene.moving_x, scene.moving_y, 0);
    }
  }

 private:
  std::unordered_map<std::size_t, std::uint16_t> observe(const StripScene& scene,
                                                         const std::vector<Vec3>& ground_points,
                                                         const std::unordered_map<std::size_t, std::uint16_t>& previous,
                                                         std::mt19937& random, StripKeyframe& frame) {
    std::normal_distribution<double> normal(0, 1);
    std::uniform_real_distribution<double> uniform(0, 1);
    std::unordered_map<std::size_t, std::uint16_t> seen;
    std::vector<std::size_t> visible;
    for (std::size_t i = 0; i < ground_points.size(); ++i) {
      const Vec3 x = frame.truth * ground_points[i];
      if (x.z() <= 0 || std::abs(x.x() / x.z()) > 0.6 || std::abs(x.y() / x.z()) > 0.6) continue;
      const Vec2 pixel = pixel_from_normalised(camera, Vec2(x.x() / x.z(), x.y() / x.z()));
      if (pixel.x() < 8 || pixel.y() < 8 || pixel.x() > 631 || pixel.y() > 471) continue;
      visible.push_back(i);
    }
    std::shuffle(visible.begin(), visible.end(), random);
    if (visible.size() > limits::max_corners) visible.resize(limits::max_corners);
    for (const std::size_t i : visible) {
      const Vec3 x = frame.truth * ground_points[i];
      const Vec2 pixel = pixel_from_normalised(camera, Vec2(x.x() / x.z(), x.y() / x.z()));
      seen[i] = static_cast<std::uint16_t>(frame.corners.size());
      if (scene.walk_px > 0) {
        const Vec2 step(scene.walk_px * normal(random), scene.walk_px * normal(random));
        off_point_[i] = previous.count(i) > 0 ? Vec2(off_point_[i] + step) : Vec2::Zero();
      }
      const Vec2 seen_at = pixel + off_point_[i];
      const double noise = scene.tails > 0 && uniform(random) < scene.tails ? 10 * scene.noise_px : scene.noise_px;
      (void)frame.corners.push_back({static_cast<float>(seen_at.x() + noise * normal(random)),
                                     static_cast<float>(seen_at.y() + noise * normal(random)), 1});
    }
    std::vector<Match> matches;
    for (const std::size_t i : visible) {
      const auto found = previous.find(i);
      if (found != previous.end()) matches.push_back({found->second, seen[i], 0.9F, 0, 0});
    }
    // Wrong matches trade their partners, as repeated texture makes them.
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (uniform(random) < scene.wrong) wrong.push_back(i);
    }
    for (std::size_t i = 1; i < wrong.size(); ++i) std::swap(matches[wrong[i - 1]].b, matches[wrong[i]].b);
    std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) { return a.a < b.a; });
    for (Match& m : matches) {
      m.xb = frame.corners[m.b].x;
      m.yb = frame.corners[m.b].y;
      (void)frame.matches.push_back(m);
    }
    return seen;
  }

  std::vector<Vec2> off_point_;  ///< of each ground point's corner, px
};

}  // namespace ilp::test
