// Real images: windows of the Dubrovnik problem, their observations made ideal with the given focal lengths and
// distortion.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp::test {

/// 5 cameras, the first two fixed, 1200 points, 4305 observations.
inline constexpr const char* dubrovnik_five = "window-5-1200.txt";
/// 16 cameras, the first two fixed, and as many of the 22106 points as fit, in the order of the file.
inline constexpr const char* dubrovnik_sixteen = "problem-16-22106-pre.txt";

/// False when the data are absent. Points that fewer than three cameras see are left out.
[[nodiscard]] inline bool read_dubrovnik(BundleProblem& problem, const char* name = dubrovnik_five) {
  std::ifstream file(std::string("../shared/data/bal_dubrovnik_16/") + name);
  std::size_t cameras = 0, points = 0, observations = 0;
  if (!(file >> cameras >> points >> observations)) return false;
  problem = {};
  std::vector<BundleObservation> raw(observations);
  std::vector<std::size_t> views(points);
  for (BundleObservation& o : raw) {
    file >> o.camera >> o.point >> o.x >> o.y;
    ++views[o.point];
  }
  std::vector<std::array<double, 2>> distortion;
  for (std::size_t i = 0; i < cameras; ++i) {
    double v[9];
    for (double& value : v) file >> value;
    RigidTransform pose;  // theirs looks along -z with y up
    const Eigen::Vector3d axis(v[0], v[1], v[2]);
    pose.rotation = Vec3(1, -1, -1).asDiagonal() * Eigen::AngleAxisd(axis.norm(), axis.normalized()).toRotationMatrix();
    pose.translation = Vec3(v[3], -v[4], -v[5]);
    BundleCamera camera{.pose = pose_from(pose), .fx = v[6], .fy = v[6], .fixed = i < 2};
    distortion.push_back({v[7], v[8]});
    (void)problem.cameras.push_back(camera);
  }
  constexpr std::size_t left_out = limits::max_bundle_points;
  std::vector<std::size_t> kept(points, left_out);
  std::size_t kept_views = 0;
  for (std::size_t i = 0; i < points; ++i) {
    BundlePoint point;
    for (double& x : point.position) file >> x;
    if (views[i] < 3 || kept_views + views[i] > limits::max_bundle_observations) continue;
    kept[i] = problem.points.size();
    if (!problem.points.push_back(point)) break;
    kept_views += views[i];
  }
  for (BundleObservation& o : raw) {
    if (kept[o.point] >= problem.points.size()) continue;
    o.point = static_cast<std::uint16_t>(kept[o.point]);
    const double f = problem.cameras[o.camera].fx;
    const double distorted = std::hypot(o.x, o.y) / f;
    double r = distorted;
    for (int i = 0; i < 100; ++i) {
      r = distorted / (1 + r * r * (distortion[o.camera][0] + r * r * distortion[o.camera][1]));
    }
    o.x *= r / distorted;
    o.y *= -r / distorted;
    (void)problem.observations.push_back(o);
  }
  return file.good() || file.eof();
}

}  // namespace ilp::test
