#include "fsw/vision/multiview/p3p.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "fsw/vision/twoview/solvers/cubic_roots.hpp"

namespace ilp {
namespace {

/// Symmetric 3x3 matrix with one zero eigenvalue: the unit eigenvectors of the other two, the larger in magnitude
/// first. (Lambda Twist, algorithm 2.)
bool eigen_with_known_zero(const Mat3& m, Vec3 vectors[2], double (&values)[3]) {
  const double b = -m.trace();
  const double c =
      m(0, 0) * (m(1, 1) + m(2, 2)) + m(1, 1) * m(2, 2) - m(0, 1) * m(0, 1) - m(0, 2) * m(0, 2) - m(1, 2) * m(1, 2);
  if (append_quadratic_roots(1, b, c, values, 0) < 2) return false;
  const double mixed_0 = m(0, 1) * m(1, 2) - m(0, 2) * m(1, 1);
  const double mixed_1 = m(0, 1) * m(0, 2) - m(0, 0) * m(1, 2);
  for (int i = 0; i < 2; ++i) {
    const double e = values[i];
    const double denominator = e * (m(0, 0) + m(1, 1)) - m(0, 0) * m(1, 1) - e * e + m(0, 1) * m(0, 1);
    const double a0 = -(e * m(0, 2) + mixed_0) / denominator;
    const double a1 = -(e * m(1, 2) + mixed_1) / denominator;
    const double inverse_norm = 1 / std::sqrt(a0 * a0 + a1 * a1 + 1);
    vectors[i] = Vec3(a0 * inverse_norm, a1 * inverse_norm, inverse_norm);
    if (!std::isfinite(inverse_norm) || !(inverse_norm > 0)) return false;
  }
  return true;
}

/// The law of cosines for the three pairs, b = -2 cos.
struct Triangle {
  double a12, a13, a23;
  double b12, b13, b23;
};

/// Gauss-Newton on the three distances, because the closed form loses digits near degenerate views.
void refine_distances(const Triangle& t, Vec3& l) {
  constexpr int steps = 5;
  for (int i = 0; i < steps; ++i) {
    const double l1 = l[0];
    const double l2 = l[1];
    const double l3 = l[2];
    const double r1 = l1 * l1 + l2 * l2 + t.b12 * l1 * l2 - t.a12;
    const double r2 = l1 * l1 + l3 * l3 + t.b13 * l1 * l3 - t.a13;
    const double r3 = l2 * l2 + l3 * l3 + t.b23 * l2 * l3 - t.a23;
    if (std::fabs(r1) + std::fabs(r2) + std::fabs(r3) < 1e-14 * (t.a12 + t.a13 + t.a23)) return;
    const double d11 = 2 * l1 + t.b12 * l2;
    const double d12 = 2 * l2 + t.b12 * l1;
    const double d21 = 2 * l1 + t.b13 * l3;
    const double d23 = 2 * l3 + t.b13 * l1;
    const double d32 = 2 * l2 + t.b23 * l3;
    const double d33 = 2 * l3 + t.b23 * l2;
    const double determinant = -d11 * d23 * d32 - d12 * d21 * d33;
    if (determinant == 0) return;
    const double x1 = (-d23 * d32 * r1 - d12 * d33 * r2 + d12 * d23 * r3) / determinant;
    const double x2 = (-d21 * d33 * r1 + d11 * d33 * r2 - d11 * d23 * r3) / determinant;
    const double x3 = (d21 * d32 * r1 - d11 * d32 * r2 - d12 * d21 * r3) / determinant;
    l -= Vec3(x1, x2, x3);
  }
}

}  // namespace

int solve_p3p(const Vec3 bearing[3], const Vec3 point[3], RigidTransform cam_from_world[max_p3p_solutions]) {
  const Vec3 d12 = point[0] - point[1];
  const Vec3 d13 = point[0] - point[2];
  const Vec3 d23 = point[1] - point[2];
  const Vec3 normal = d12.cross(d13);
  const double c12 = bearing[0].dot(bearing[1]);
  const double c13 = bearing[0].dot(bearing[2]);
  const double c23 = bearing[1].dot(bearing[2]);
  const Triangle t{d12.squaredNorm(), d13.squaredNorm(), d23.squaredNorm(), -2 * c12, -2 * c13, -2 * c23};
  if (!(normal.squaredNorm() > 1e-12 * t.a12 * t.a13)) return 0;

  // Which member of the pencil D1 + g D2 of quadrics is degenerate (eq. 15).
  const double blob = c12 * c23 * c13 - 1;
  const double s12 = 1 - c12 * c12;
  const double s13 = 1 - c13 * c13;
  const double s23 = 1 - c23 * c23;
  const double p3 = t.a13 * (t.a23 * s13 - t.a13 * s23);
  const double p2 = 2 * blob * t.a23 * t.a13 + t.a13 * (2 * t.a12 + t.a13) * s23 + t.a23 * (t.a23 - t.a12) * s13;
  const double p1 = t.a23 * (t.a13 - t.a23) * s12 - t.a12 * t.a12 * s23 - 2 * t.a12 * (blob * t.a23 + t.a13 * s23);
  const double p0 = t.a12 * (t.a12 * s23 - t.a23 * s12);
  if (p3 == 0) return 0;
  const double g = real_root_of_cubic(p2 / p3, p1 / p3, p0 / p3);
  if (!std::isfinite(g)) return 0;

  Mat3 quadric;
  quadric(0, 0) = t.a23 * (1 - g);
  quadric(0, 1) = quadric(1, 0) = 0.5 * t.a23 * t.b12;
  quadric(0, 2) = quadric(2, 0) = -0.5 * t.a23 * t.b13 * g;
  quadric(1, 1) = t.a23 - t.a12 + t.a13 * g;
  quadric(1, 2) = quadric(2, 1) = 0.5 * t.b23 * (t.a13 * g - t.a12);
  quadric(2, 2) = g * (t.a13 - t.a23) - t.a12;
  Vec3 v[2];
  double eigenvalue[3];
  if (!eigen_with_known_zero(quadric, v, eigenvalue)) return 0;
  const double ratio = -eigenvalue[1] / eigenvalue[0];
  const double s_abs = ratio > 0 ? std::sqrt(ratio) : 0;

  Mat3 world;
  world.col(0) = d12;
  world.col(1) = d13;
  world.col(2) = normal;
  const Mat3 world_inverse = world.inverse();

  int count = 0;
  for (const double s : {s_abs, -s_abs}) {
    // The plane l1 = w0 l2 + w1 l3 of this factor, put into the remaining quadric: tau = l3 / l2.
    const double w2 = 1 / (s * v[1][0] - v[0][0]);
    const double w0 = (v[0][1] - s * v[1][1]) * w2;
    const double w1 = (v[0][2] - s * v[1][2]) * w2;
    const double a = 1 / ((t.a13 - t.a12) * w1 * w1 - t.a12 * t.b13 * w1 - t.a12);
    const double b = (t.a13 * t.b12 * w1 - t.a12 * t.b13 * w0 - 2 * w0 * w1 * (t.a12 - t.a13)) * a;
    const double c = ((t.a13 - t.a12) * w0 * w0 + t.a13 * t.b12 * w0 + t.a13) * a;
    double tau[3];
    const int roots = append_quadratic_roots(1, b, c, tau, 0);
    for (int i = 0; i < roots; ++i) {
      const double ratio32 = tau[i];
      const double d = t.a23 / (ratio32 * (t.b23 + ratio32) + 1);
      if (!(ratio32 > 0) || !(d > 0) || count == max_p3p_solutions) continue;
      const double l2 = std::sqrt(d);
      const double l3 = ratio32 * l2;
      const double l1 = w0 * l2 + w1 * l3;
      if (!(l1 >= 0)) continue;
      Vec3 l(l1, l2, l3);
      refine_distances(t, l);
      const Vec3 x1 = l[0] * bearing[0];
      const Vec3 y12 = x1 - l[1] * bearing[1];
      const Vec3 y13 = x1 - l[2] * bearing[2];
      Mat3 camera;
      camera.col(0) = y12;
      camera.col(1) = y13;
      camera.col(2) = y12.cross(y13);
      RigidTransform& out = cam_from_world[count];
      // Over a plane seen straight from above the distances, and thus this product, may be off by thousandths.
      double q[4];
      quaternion_from_rotation(camera * world_inverse, q);
      out.rotation = rotation_from_quaternion(q);
      out.translation = x1 - out.rotation * point[0];
      if (out.rotation.allFinite() && out.translation.allFinite()) ++count;
    }
  }
  return count;
}

}  // namespace ilp
