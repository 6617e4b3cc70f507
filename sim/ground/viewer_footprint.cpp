#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/viewer_data.hpp"

namespace ilp::ground {
namespace {

constexpr int points_per_side = 6;
/// A ray that meets the ground farther off than so many flying heights says nothing about the footprint.
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

double relief_at(const StripResult& strip, double x, double y) {
  const GroundGrid& grid = *strip.grid;
  const double column = std::floor(grid.column_of(x) + 0.5), row = std::floor(grid.row_of(y) + 0.5);
  if (!(column >= 0) || !(row >= 0) || column >= grid.height.width || row >= grid.height.height) return 0;
  const float z = grid.height.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
  return std::isfinite(z) ? z - strip.plane.at(x, y) : 0;
}

}  // namespace

std::vector<double> viewer_footprint(const Keyframe& keyframe, const StripResult& strip) {
  std::vector<double> outline;
  if (!strip.grid || !keyframe.posed() || !(keyframe.camera.fx > 0)) return outline;
  const Pose pose = pose_of(*keyframe.pose);
  const Mat3 world_from_cam = rotation_from_quaternion(pose.q_cam_from_world).transpose();
  const Vec3 centre(pose.centre[0], pose.centre[1], pose.centre[2]);
  const Plane& plane = strip.plane;
  const double above = centre.z() - plane.at(centre.x(), centre.y());
  for (const Vec2& pixel : border(keyframe.camera)) {
    const Vec2 n = normalised_from_pixel(keyframe.camera, pixel);
    const Vec3 ray = world_from_cam * Vec3(n.x(), n.y(), 1);
    const double sinking = ray.z() - plane.a * ray.x() - plane.b * ray.y();
    double relief = 0;
    Vec3 point = centre;
    // The surface is nearly its mean plane: a few steps from the one to the other converge.
    for (int step = 0; step < 5; ++step) {
      const double along = (relief - above) / sinking;
      if (!(along > 0) || along * ray.norm() > farthest * std::fabs(above)) return {};
      point = centre + along * ray;
      relief = relief_at(strip, point.x(), point.y());
    }
    outline.insert(outline.end(), {point.x(), point.y(), plane.at(point.x(), point.y()) + relief});
  }
  return outline;
}

}  // namespace ilp::ground
