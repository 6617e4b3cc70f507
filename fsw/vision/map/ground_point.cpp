#include "fsw/vision/map/ground_point.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

constexpr double least_fall = 0.05;  // of a line of sight: 3 degrees below the horizon
constexpr int most_looks = 10;

}  // namespace

bool ground_on_level(const RigidTransform& camera_from_map, const Vec3& direction, double ground_m, Vec3& ground) {
  const Vec3 centre = camera_centre(camera_from_map);
  const Vec3 down = camera_from_map.rotation.transpose() * direction;
  if (!(down.z() < -least_fall * down.norm()) || !(centre.z() > ground_m)) return false;
  ground = centre + (ground_m - centre.z()) / down.z() * down;
  return ground.allFinite();
}

double height_at(const MapWindow& window, double x_m, double y_m) {
  const double column = std::clamp((x_m - window.x0_m) / window.pixel_m - 0.5, 0.0, window.width - 1.0);
  const double row = std::clamp((window.y0_m - y_m) / window.pixel_m - 0.5, 0.0, window.height - 1.0);
  const std::int32_t c = std::min(static_cast<std::int32_t>(column), window.width - 2);
  const std::int32_t r = std::min(static_cast<std::int32_t>(row), window.height - 2);
  const double right = column - c, down = row - r;
  const auto height = [&](std::int32_t cell) {
    return window.known[cell] != 0 ? static_cast<double>(window.height_m[cell]) : window.ground_m;
  };
  const std::int32_t first = r * window.width + c, next = first + window.width;
  const double above = height(first) + right * (height(first + 1) - height(first));
  const double below = height(next) + right * (height(next + 1) - height(next));
  return above + down * (below - above);
}

bool ground_on_axis(const RigidTransform& camera_from_map, const MapWindow& window, double ground_m, Vec3& ground) {
  for (int look = 0; look < most_looks; ++look) {
    if (!ground_on_level(camera_from_map, Vec3(0, 0, 1), ground_m, ground)) return false;
    ground_m = height_at(window, ground.x(), ground.y());
  }
  return true;
}

Eigen::Matrix<double, 2, 6> ground_by_pose(const RigidTransform& camera_from_map, const Vec3& ground) {
  // g = c + t d with d = R^T p, and t so that g stays level. R' = exp([w]x) R gives dd = R^T [p]x w.
  const Vec3 p = camera_from_map * ground;
  const Mat3 by_turn = camera_from_map.rotation.transpose() * cross_matrix(p);
  const Vec3 d = camera_from_map.rotation.transpose() * p;
  Eigen::Matrix<double, 2, 6> by;
  for (int axis = 0; axis < 2; ++axis) {
    const double slope = d(axis) / d.z();
    for (int k = 0; k < 3; ++k) {
      by(axis, k) = by_turn(axis, k) - slope * by_turn(2, k);
      by(axis, 3 + k) = (k == axis ? 1.0 : 0.0) - (k == 2 ? slope : 0.0);
    }
  }
  return by;
}

Mat2 ground_covariance(const RigidTransform& camera_from_map, const Vec3& ground, const PoseCovariance& covariance) {
  const Eigen::Matrix<double, 2, 6> by = ground_by_pose(camera_from_map, ground);
  return by * covariance * by.transpose();
}

double largest_sigma(const Mat2& covariance) {
  const double half_sum = 0.5 * (covariance(0, 0) + covariance(1, 1));
  const double half_difference = 0.5 * (covariance(0, 0) - covariance(1, 1));
  // By rounding, the two need not be the same, nor have the same sign.
  const double across = 0.5 * (covariance(0, 1) + covariance(1, 0));
  const double root = std::sqrt(half_difference * half_difference + across * across);
  return std::sqrt(std::max(half_sum + root, 0.0));
}

}  // namespace ilp
