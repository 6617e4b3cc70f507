#include "sim/ground/export/footprint.hpp"

#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp::exports {
namespace {

constexpr int points_per_side = 6;
/// A ray that meets the ground farther off than this many flying heights says nothing about the footprint.
constexpr double farthest = 20;

std::vector<Vec2> border(const CameraModel& camera) {
  const double right = camera.width - 0.5, bottom = camera.height - 0.5;
  const Vec2 corners[] = {{-0.5, -0.5}, {right, -0.5}, {right, bottom}, {-0.5, bottom}};
  std::vector<Vec2> points;
  for (std::size_t side = 0; side < 4; ++side) {
    const Vec2& from = corners[side];
    const Vec2& to = corners[(side + 1) % 4];
    for (int i = 0; i < points_per_side; ++i) points.emplace_back(from + (to - from) * i / points_per_side);
  }
  return points;
}

}  // namespace

std::vector<Vec3> footprint(const CameraModel& camera, const Pose& pose, const map::Plane& plane,
                            const std::function<double(double x, double y)>& relief) {
  std::vector<Vec3> outline;
  if (!(camera.fx > 0)) return outline;
  const Mat3 world_from_cam = rotation_from_quaternion(pose.q_cam_from_world).transpose();
  const Vec3 centre(pose.centre[0], pose.centre[1], pose.centre[2]);
  const double above = centre.z() - plane.at(centre.x(), centre.y());
  for (const Vec2& pixel : border(camera)) {
    const Vec2 n = normalised_from_pixel(camera, pixel);
    const Vec3 ray = world_from_cam * Vec3(n.x(), n.y(), 1);
    const double sinking = ray.z() - plane.a * ray.x() - plane.b * ray.y();
    double height = 0;
    Vec3 point = centre;
    // The surface is nearly its mean plane: a few steps from the one to the other converge.
    for (int step = 0; step < 5; ++step) {
      const double along = (height - above) / sinking;
      if (!(along > 0) || along * ray.norm() > farthest * std::fabs(above)) return {};
      point = centre + along * ray;
      height = relief(point.x(), point.y());
    }
    outline.emplace_back(point.x(), point.y(), plane.at(point.x(), point.y()) + height);
  }
  return outline;
}

}  // namespace ilp::exports
