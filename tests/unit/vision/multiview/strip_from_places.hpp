// Strips along any places, with known truth and errors of corners, but no wrong matches.
#pragma once

#include <random>
#include <unordered_map>
#include <vector>

#include "tests/unit/vision/multiview/synthetic_strip.hpp"

namespace ilp::test {

/// Ground of `relief` (as SyntheticStrip's) seen from `centres` (z the height) by a camera that looks down but for a
/// swing of up to `tilt` about each axis, rad; errors of the corners of 0.2 px, no wrong matches.
inline SyntheticStrip strip_from_places(const std::vector<Vec3>& centres, unsigned seed, double relief = 0,
                                        double tilt = 0.15) {
  SyntheticStrip strip({.keyframes = 1});
  strip.keyframes.clear();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, 0.2);
  std::vector<Vec3> ground;
  for (int i = 0; i < 5000; ++i) {
    const double x = 0.3 + 1.6 * uniform(random);
    const double y = 1.6 * uniform(random);
    ground.emplace_back(x, y, SyntheticStrip::ground(x, y, relief));
  }
  std::unordered_map<std::size_t, std::uint16_t> previous;
  for (const Vec3& centre : centres) {
    StripKeyframe frame;
    const Vec3 swing(tilt * uniform(random), tilt * uniform(random), 0.2 * uniform(random));
    frame.truth.rotation = rotation_from_vector(swing) * Vec3(1, -1, -1).asDiagonal();
    frame.truth.translation = -(frame.truth.rotation * centre);
    std::unordered_map<std::size_t, std::uint16_t> seen;
    for (std::size_t i = 0; i < ground.size() && frame.corners.size() < 600; ++i) {
      const Vec3 x = frame.truth * ground[i];
      if (x.z() <= 0 || std::abs(x.x() / x.z()) > 0.6 || std::abs(x.y() / x.z()) > 0.6) continue;
      const Vec2 pixel = pixel_from_normalised(strip.camera, Vec2(x.x() / x.z(), x.y() / x.z()));
      if (pixel.x() < 8 || pixel.y() < 8 || pixel.x() > 631 || pixel.y() > 471) continue;
      const auto index = static_cast<std::uint16_t>(frame.corners.size());
      const auto u = static_cast<float>(pixel.x() + noise(random));
      const auto v = static_cast<float>(pixel.y() + noise(random));
      seen[i] = index;
      (void)frame.corners.push_back({u, v, 1});
      const auto found = previous.find(i);
      if (found != previous.end()) (void)frame.matches.push_back({found->second, index, 0.9F, u, v});
    }
    previous = seen;
    strip.keyframes.push_back(frame);
  }
  return strip;
}

}  // namespace ilp::test
