#include "fsw/shared/measured_keyframe.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/shared/local_plane.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

bool valid(const FixRecord& fix) {
  double sum = fix.ground_depth + fix.ground_depth_sigma + fix.map_sigma_m;
  for (const double v : fix.ground_m) sum += v;
  for (const double v : fix.centre_m) sum += v;
  for (const double v : fix.covariance) sum += v;
  for (const double v : fix.ground_covariance) sum += v;
  return std::isfinite(sum) && is_unit_quaternion(fix.q_cam_from_map) && fix.ground_covariance[0] > 0 &&
         fix.ground_covariance[2] > 0 && fix.ground_height_sigma_m > 0;
}

/// An element of a symmetric matrix that is kept by its lower triangle.
double element(const double (&triangle)[21], int row, int column) {
  if (row < column) std::swap(row, column);
  return triangle[row * (row + 1) / 2 + column];
}

}  // namespace

navigation::FixMeasurement fix_measurement(const FixRecord& fix, const BodyPlace& origin) {
  navigation::FixMeasurement out;
  if (fix.state != FixState::accepted || !valid(fix)) return out;
  std::copy_n(fix.ground_m, 3, out.ground_m);
  Mat3 cam_from_level = rotation_from_quaternion(fix.q_cam_from_map);
  const BodyPlace map = map_origin_of(fix);
  const bool same = origin.longitude_deg == map.longitude_deg && origin.latitude_deg == map.latitude_deg;
  if (fix.body != Body::none && !same) {
    const BodyPlace ground = place_from_plane(fix.body, map, fix.ground_m);
    plane_from_place(fix.body, origin, ground, out.ground_m);
    const double turn = plane_north(fix.body, map, ground) - plane_north(fix.body, origin, ground);
    cam_from_level = cam_from_level * rotation_from_vector(Vec3(0, 0, turn));
  }
  quaternion_from_rotation(cam_from_level, out.q_cam_from_level);
  Mat3 turn, place;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      turn(i, k) = element(fix.covariance, i, k);
      place(i, k) = element(fix.covariance, i + 3, k + 3);
    }
  }
  navigation::level_sigmas(turn, cam_from_level, out.tilt_sigma_rad, out.heading_sigma_rad);
  out.ground_sigma_m[0] = std::sqrt(fix.ground_covariance[0]);
  out.ground_sigma_m[1] = std::sqrt(fix.ground_covariance[2]);
  out.ground_sigma_m[2] = fix.ground_height_sigma_m;
  const Vec3 axis = rotation_from_quaternion(fix.q_cam_from_map).row(2);
  out.distance_m = (vector_of(fix.ground_m) - vector_of(fix.centre_m)).norm();
  out.distance_sigma_m =
      std::sqrt(std::max(0.0, axis.dot(place * axis)) + fix.ground_height_sigma_m * fix.ground_height_sigma_m);
  out.depth = fix.ground_depth;
  out.depth_sigma = fix.ground_depth_sigma;
  out.map_sigma_m = fix.map_sigma_m;
  // What the map has wrong, or does not resolve, is the same for all that look at it.
  constexpr double shared = 0.25;
  out.shared = shared;
  return out;
}

navigation::MeasuredKeyframe measured_keyframe(const PoseRecord& pose, const NavigationRecord& measured, Body body,
                                               const BodyPlace& origin) {
  navigation::MeasuredKeyframe out;
  out.keyframe_id = pose.id;
  out.time_ns = measured.time_ns;
  std::copy_n(pose.centre, 3, out.centre);
  std::copy_n(pose.q_cam_from_world, 4, out.q_cam_from_strip);
  out.ground_distance = pose.ground_distance;
  out.ground_distance_sigma = pose.ground_distance_sigma;
  out.height_m = measured.height_m;
  out.height_sigma_m = measured.height_sigma_m;
  std::copy_n(measured.q_cam_from_level, 4, out.q_cam_from_level);
  out.tilt_sigma_rad = measured.tilt_sigma_rad;
  out.heading_sigma_rad = measured.heading_sigma_rad;
  if (has_place(measured, body)) {
    offset_from(body, origin, place_of(measured), out.place_m);
    out.horizontal_sigma_m = measured.horizontal_sigma_m;
    out.vertical_sigma_m = measured.vertical_sigma_m;
  }
  std::copy_n(measured.velocity_m_s, 3, out.velocity_m_s);
  out.velocity_sigma_m_s = measured.velocity_sigma_m_s;
  return out;
}

}  // namespace ilp
