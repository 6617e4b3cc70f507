#include "fsw/vision/multiview/ground_below.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/median.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {
namespace {

constexpr std::size_t most_points = 24;
constexpr std::size_t least_points = 8;
constexpr double farthest_share = 1.0 / 3;
constexpr double farthest_deviations = 4;

struct Near {
  double off2 = 0;  ///< squared distance from the vertical
  Vec3 from_camera = Vec3::Zero();
};

struct Nearest {
  std::array<Near, most_points> at;
  std::size_t count = 0;

  void add(const Near& point) {
    if (count == most_points && !(point.off2 < at[count - 1].off2)) return;
    std::size_t i = count < most_points ? count++ : count - 1;
    for (; i > 0 && point.off2 < at[i - 1].off2; --i) at[i] = at[i - 1];
    at[i] = point;
  }
};

/// Height and slopes of the plane below the camera through the points that are marked.
bool fit_plane(const Nearest& points, const std::array<bool, most_points>& used, Vec3& plane) {
  Mat3 normal = Mat3::Zero();
  Vec3 right = Vec3::Zero();
  for (std::size_t i = 0; i < points.count; ++i) {
    if (!used[i]) continue;
    const Vec3 row(1, points.at[i].from_camera.x(), points.at[i].from_camera.y());
    normal += row * row.transpose();
    right += row * points.at[i].from_camera.z();
  }
  const double determinant = normal.determinant();
  const double size = normal(0, 0) * normal(1, 1) * normal(2, 2);
  if (!(determinant > 1e-9 * size)) return false;
  plane = normal.inverse() * right;
  return true;
}

double deviation(const Near& point, const Vec3& plane) {
  return point.from_camera.z() - plane.dot(Vec3(1, point.from_camera.x(), point.from_camera.y()));
}

}  // namespace

bool ground_below(const Tracks& tracks, const double (&centre)[3], GroundBelow& ground) {
  Nearest points;
  for (const Track& track : tracks) {
    if (track.phase != TrackPhase::point && track.phase != TrackPhase::final_point) continue;
    Near point;
    for (int k = 0; k < 3; ++k) point.from_camera[k] = track.position[k] - centre[k];
    point.off2 = point.from_camera.x() * point.from_camera.x() + point.from_camera.y() * point.from_camera.y();
    if (point.from_camera.z() < 0) points.add(point);
  }
  if (points.count < least_points) return false;

  std::array<double, most_points> values{};
  for (std::size_t i = 0; i < points.count; ++i) values[i] = points.at[i].from_camera.z();
  Vec3 plane(upper_median(std::span(values).first(points.count)), 0, 0);
  std::array<bool, most_points> used{};
  double scatter = 0;
  std::size_t count = 0;
  // The first plane is level through the median; the second one leaves out what is far from the first.
  for (int turn = 0; turn < 2; ++turn) {
    for (std::size_t i = 0; i < points.count; ++i) values[i] = std::fabs(deviation(points.at[i], plane));
    const double most = farthest_deviations * 1.4826 * upper_median(std::span(values).first(points.count));
    count = 0;
    for (std::size_t i = 0; i < points.count; ++i) {
      used[i] = std::fabs(deviation(points.at[i], plane)) <= most;
      count += used[i] ? 1 : 0;
    }
    if (count < least_points || !fit_plane(points, used, plane)) return false;
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    const double off = deviation(points.at[i], plane);
    if (used[i]) scatter += off * off;
  }
  ground.distance = -plane[0];
  ground.sigma = std::sqrt(scatter / static_cast<double>(count) / static_cast<double>(count));
  const double farthest = farthest_share * ground.distance;
  return ground.distance > 0 && points.at[least_points - 1].off2 < farthest * farthest;
}

}  // namespace ilp
