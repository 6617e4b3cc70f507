// Decomposes an essential matrix into poses, and tests whether rays meet in front of the cameras.
#pragma once

#include <cstddef>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// Gives the four b_from_a with [t]x R = E up to scale and sign, |t| = 1: (R1, t), (R1, -t), (R2, t), (R2, -t). E must
/// be essential (two equal singular values, one zero). Returns false if it is zero or not finite. Source: B. Horn,
/// "Recovering Baseline and Orientation from 'Essential' Matrix", 1990: rotation and baseline from cofactors, without a
/// decomposition.
bool decompose_essential(const Mat3& essential, RigidTransform poses[4]);

/// The essential matrix E of a pose: b^T E a = 0 for the rays a and b of a point.
[[nodiscard]] Mat3 essential_from_pose(const RigidTransform& b_from_a);

/// True if the rays (any length, z > 0) meet in front of both cameras, or are parallel to within `min_angle_rad`: noise
/// then decides where they meet.
[[nodiscard]] bool meets_in_front(const RigidTransform& b_from_a, const Vec3& ray_a, const Vec3& ray_b,
                                  double min_angle_rad);

}  // namespace ilp
