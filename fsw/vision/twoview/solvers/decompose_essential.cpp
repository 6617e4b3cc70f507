#include "fsw/vision/twoview/solvers/decompose_essential.hpp"

#include <cmath>

namespace ilp {
namespace {

Mat3 cofactors(const Mat3& m) {
  Mat3 result;
  result.row(0) = m.row(1).cross(m.row(2));
  result.row(1) = m.row(2).cross(m.row(0));
  result.row(2) = m.row(0).cross(m.row(1));
  return result;
}

/// Removes rounding errors through the unit quaternion.
Mat3 orthonormal(const Mat3& rotation) {
  double q[4];
  quaternion_from_rotation(rotation, q);
  return rotation_from_quaternion(q);
}

}  // namespace

bool decompose_essential(const Mat3& essential, RigidTransform poses[4]) {
  const double length2 = 0.5 * essential.squaredNorm();
  if (!(length2 > 0) || !std::isfinite(length2)) return false;
  const Mat3 e = essential / std::sqrt(length2);
  // cof(E) = t t^T R: its columns are multiples of t, the longest of them the most exact.
  const Mat3 cofactor = cofactors(e);
  int longest = 0;
  for (int c = 1; c < 3; ++c) {
    if (cofactor.col(c).squaredNorm() > cofactor.col(longest).squaredNorm()) longest = c;
  }
  const double norm = cofactor.col(longest).norm();
  if (!(norm > 1e-9)) return false;
  const Vec3 t = cofactor.col(longest) / norm;
  // [t] E = (t t^T - I) R, so that cof(E) - [t] E = R; the other sign of t gives the twisted pair.
  const Mat3 cross = cross_matrix(t) * e;
  const Mat3 first = orthonormal(cofactor - cross);
  const Mat3 second = orthonormal(cofactor + cross);
  poses[0] = {first, t};
  poses[1] = {first, -t};
  poses[2] = {second, t};
  poses[3] = {second, -t};
  return true;
}

Mat3 essential_from_pose(const RigidTransform& b_from_a) {
  return cross_matrix(b_from_a.translation) * b_from_a.rotation;
}

bool meets_in_front(const RigidTransform& b_from_a, const Vec3& ray_a, const Vec3& ray_b, double min_angle_rad) {
  // depth_b q = depth_a p + t in the least-squares sense; the denominators are |p x q|^2 > 0.
  const Vec3 p = b_from_a.rotation * ray_a;
  const Vec3& q = ray_b;
  const Vec3& t = b_from_a.translation;
  const Vec3 normal = p.cross(q);
  if (normal.squaredNorm() < min_angle_rad * min_angle_rad * p.squaredNorm() * q.squaredNorm()) return p.dot(q) > 0;
  return q.cross(t).dot(normal) > 0 && p.cross(t).dot(normal) > 0;
}

}  // namespace ilp
