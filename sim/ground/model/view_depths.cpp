#include "sim/ground/model/view_depths.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

constexpr double near_px = 40;
constexpr std::size_t least_plane_points = 10;
constexpr double most_relief = 0.05;
constexpr int rounds = 5;

}  // namespace

ViewDepths::ViewDepths(const Scene& scene, const World& world)
    : depths_(scene.views.size()), planes_(scene.views.size()) {
  for (const View& view : scene.views)
    most_relief_.push_back(most_relief * std::min(1.0, view.camera.width / view.camera.fx));
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    const Vec3* point = world.point(t);
    if (point == nullptr) continue;
    for (const Sighting& seen : scene.tracks[t].seen) {
      const RigidTransform* pose = world.pose(seen.view);
      const double z = pose == nullptr ? 0 : (*pose * *point).z();
      if (z > 0) depths_[seen.view].push_back({seen.x, seen.y, 1 / z});
    }
  }
}

/// Least squares, repeated with Tukey's weights.
ViewDepths::Plane ViewDepths::plane_through(const std::vector<InverseDepth>& depths, double most) {
  if (depths.size() < least_plane_points) return {true};
  Vec3 plane = Vec3::Zero();
  double middle = 1;
  std::vector<double> weights(depths.size(), 1);
  for (int round = 0; round < rounds; ++round) {
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const Vec3 row(depths[i].x, depths[i].y, 1);
      normal += weights[i] * row * row.transpose();
      right += weights[i] * depths[i].value * row;
    }
    plane = normal.inverse() * right;
    std::vector<double> residuals;
    for (const InverseDepth& one : depths)
      residuals.push_back(std::fabs(plane.dot(Vec3(one.x, one.y, 1)) / one.value - 1));
    middle = host::median(residuals);
    if (!std::isfinite(middle)) return {true};
    for (std::size_t i = 0; i < depths.size(); ++i) {
      const double r = residuals[i] / (3 * middle + 1e-9);
      weights[i] = r < 1 ? (1 - r * r) * (1 - r * r) : 0;
    }
  }
  if (middle > most) return {true};
  return {true, plane, middle};
}

std::optional<double> ViewDepths::near(std::uint32_t view, double x, double y) const {
  double weights = 0, sum = 0;
  for (const InverseDepth& one : depths_[view]) {
    const double distance = std::hypot(one.x - x, one.y - y);
    if (distance > near_px) continue;
    const double weight = 1 / (1 + distance * distance);
    weights += weight;
    sum += weight * one.value;
  }
  if (!(weights > 0)) return std::nullopt;
  return sum / weights;
}

const ViewDepths::Plane& ViewDepths::plane_of(std::uint32_t view) const {
  if (!planes_[view].fitted) planes_[view] = plane_through(depths_[view], most_relief_[view]);
  return planes_[view];
}

std::optional<double> ViewDepths::relief(std::uint32_t view) const {
  const Plane& known = plane_of(view);
  return known.plane ? std::optional(known.relief) : std::nullopt;
}

std::optional<double> ViewDepths::plane(std::uint32_t view, double x, double y) const {
  const Plane& known = plane_of(view);
  if (!known.plane) return std::nullopt;
  const double inverse = known.plane->dot(Vec3(x, y, 1));
  return inverse > 0 ? std::optional(inverse) : std::nullopt;
}

std::optional<double> ViewDepths::any(std::uint32_t view, double x, double y) const {
  const auto by_points = near(view, x, y);
  return by_points ? by_points : plane(view, x, y);
}

}  // namespace ilp::model
