#include "fsw/vision/stereo/rectify/rectification_axes.hpp"

#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

Status stereo_axes(const RigidTransform& left_from_world, const RigidTransform& right_from_world, double nearest,
                   double max_axes_angle_rad, StereoAxes& axes) {
  const Vec3 along = camera_centre(right_from_world) - camera_centre(left_from_world);
  axes.baseline = along.norm();
  if (!(axes.baseline > 1e-7 * nearest)) return impossible(RectificationFault::no_baseline);
  axes.along = along / axes.baseline;
  axes.optical_left = left_from_world.rotation.row(2).transpose();
  axes.optical_right = right_from_world.rotation.row(2).transpose();
  if (axes.optical_left.dot(axes.optical_right) < det_cos(max_axes_angle_rad)) {
    return impossible(RectificationFault::axes_apart);
  }
  return {};
}

Mat3 frame_along_baseline(const StereoAxes& axes, const Vec3& ahead) {
  const Vec3 z = (ahead - ahead.dot(axes.along) * axes.along).normalized();
  Mat3 frame;
  frame.row(0) = axes.along.transpose();
  frame.row(1) = z.cross(axes.along).transpose();
  frame.row(2) = z.transpose();
  return frame;
}

bool epipole_of(const CameraModel& camera, const RigidTransform& second_from_first, Vec2& pixel) {
  const Vec3 place = second_from_first.rotation.transpose() * second_from_first.translation;
  if (!(std::fabs(place.z()) > 0)) return false;
  pixel = pixel_from_normalised(camera, Vec2(place.x() / place.z(), place.y() / place.z()));
  return true;
}

}  // namespace ilp
