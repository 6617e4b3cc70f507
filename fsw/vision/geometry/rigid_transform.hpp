// Rigid transforms: b_from_a maps coordinates of frame a to frame b, x_b = R x_a + t (decisions.md, 15).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"

namespace ilp {

struct RigidTransform {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator*(const Vec3& x) const { return rotation * x + translation; }
};

/// c_from_a = compose(c_from_b, b_from_a).
[[nodiscard]] RigidTransform compose(const RigidTransform& c_from_b, const RigidTransform& b_from_a);
[[nodiscard]] RigidTransform inverse(const RigidTransform& b_from_a);
/// Position of the camera in the world frame.
[[nodiscard]] Vec3 camera_centre(const RigidTransform& cam_from_world);

/// Rotation by |v| radians about v (Rodrigues), with the machine-independent sine and cosine of fsw/base.
[[nodiscard]] Mat3 rotation_from_vector(const Vec3& v);
[[nodiscard]] Vec3 vector_from_rotation(const Mat3& rotation);
/// Radians.
[[nodiscard]] double rotation_angle(const Mat3& rotation);
/// The matrix whose product with x is the cross product of v and x.
[[nodiscard]] Mat3 cross_matrix(const Vec3& v);

/// q = (w, x, y, z), w >= 0, unit length.
void quaternion_from_rotation(const Mat3& rotation, double q[4]);
[[nodiscard]] Mat3 rotation_from_quaternion(const double q[4]);

[[nodiscard]] RigidTransform cam_from_world(const Pose& pose);
[[nodiscard]] Pose pose_from(const RigidTransform& cam_from_world);

}  // namespace ilp
