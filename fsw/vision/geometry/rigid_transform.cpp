#include "fsw/vision/geometry/rigid_transform.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {

RigidTransform compose(const RigidTransform& c_from_b, const RigidTransform& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

RigidTransform inverse(const RigidTransform& b_from_a) {
  const Mat3 transposed = b_from_a.rotation.transpose();
  return {transposed, -(transposed * b_from_a.translation)};
}

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Mat3 rotation_from_vector(const Vec3& v) {
  const double angle2 = v.squaredNorm();
  const Mat3 k = cross_matrix(v);
  if (angle2 < 1e-16) return Mat3::Identity() + k + 0.5 * (k * k);
  const double angle = std::sqrt(angle2);
  return Mat3::Identity() + (det_sin(angle) / angle) * k + ((1 - det_cos(angle)) / angle2) * (k * k);
}

Vec3 vector_from_rotation(const Mat3& rotation) {
  double q[4];
  quaternion_from_rotation(rotation, q);
  const Vec3 axis(q[1], q[2], q[3]);
  const double sine = axis.norm();
  if (sine < 1e-12) return 2 * axis;
  return (2 * det_atan2(sine, q[0]) / sine) * axis;
}

double rotation_angle(const Mat3& rotation) {
  return vector_from_rotation(rotation).norm();
}

void quaternion_from_rotation(const Mat3& rotation, double q[4]) {
  // Shepperd's method: divide by the largest of the four components.
  const double trace = rotation.trace();
  int largest = 0;
  double best = trace;
  for (int i = 0; i < 3; ++i) {
    if (rotation(i, i) > best) {
      best = rotation(i, i);
      largest = i + 1;
    }
  }
  if (largest == 0) {
    q[0] = 1 + trace;
    q[1] = rotation(2, 1) - rotation(1, 2);
    q[2] = rotation(0, 2) - rotation(2, 0);
    q[3] = rotation(1, 0) - rotation(0, 1);
  } else {
    const int i = largest - 1;
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    q[0] = rotation(k, j) - rotation(j, k);
    q[1 + i] = 1 + rotation(i, i) - rotation(j, j) - rotation(k, k);
    q[1 + j] = rotation(j, i) + rotation(i, j);
    q[1 + k] = rotation(k, i) + rotation(i, k);
  }
  double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (q[0] < 0) norm = -norm;
  for (int i = 0; i < 4; ++i) q[i] /= norm;
}

Mat3 rotation_from_quaternion(const double q[4]) {
  const double w = q[0];
  const double x = q[1];
  const double y = q[2];
  const double z = q[3];
  Mat3 r;
  r << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),   //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return r;
}

Vec3 camera_centre(const RigidTransform& cam_from_world) {
  return -(cam_from_world.rotation.transpose() * cam_from_world.translation);
}

RigidTransform cam_from_world(const Pose& pose) {
  RigidTransform result;
  result.rotation = rotation_from_quaternion(pose.q_cam_from_world);
  result.translation = -(result.rotation * Vec3(pose.centre[0], pose.centre[1], pose.centre[2]));
  return result;
}

Pose pose_from(const RigidTransform& cam_from_world) {
  Pose pose;
  quaternion_from_rotation(cam_from_world.rotation, pose.q_cam_from_world);
  const Vec3 centre = camera_centre(cam_from_world);
  for (int i = 0; i < 3; ++i) pose.centre[i] = centre[i];
  return pose;
}

}  // namespace ilp
