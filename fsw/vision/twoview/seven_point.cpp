#include "fsw/vision/twoview/seven_point.hpp"

#include <Eigen/LU>

#include "fsw/vision/twoview/null_space.hpp"
#include "fsw/vision/twoview/polynomial_roots.hpp"

namespace ilp {
namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.dot(b.cross(c));
}

}  // namespace

std::size_t seven_point(const Vec3 a[7], const Vec3 b[7], Mat3 fundamentals[max_seven_point_solutions]) {
  double equations[7][9];
  for (int i = 0; i < 7; ++i) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) equations[i][3 * r + c] = b[i][r] * a[i][c];
    }
  }
  double basis[2][9];
  if (!null_space<7>(equations, basis)) return 0;

  // The determinant is linear in every row of F1 + z F2.
  Vec3 p[3];
  Vec3 q[3];
  for (int i = 0; i < 9; ++i) {
    p[i / 3][i % 3] = basis[0][i];
    q[i / 3][i % 3] = basis[1][i];
  }
  const double cubic[4] = {
      triple(p[0], p[1], p[2]),
      triple(q[0], p[1], p[2]) + triple(p[0], q[1], p[2]) + triple(p[0], p[1], q[2]),
      triple(p[0], q[1], q[2]) + triple(q[0], p[1], q[2]) + triple(q[0], q[1], p[2]),
      triple(q[0], q[1], q[2]),
  };
  RealRoots<3> solver;
  double roots[3];
  const int count = solver.find(cubic, roots);
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 9; ++i) fundamentals[k](i / 3, i % 3) = basis[0][i] + roots[k] * basis[1][i];
    fundamentals[k].normalize();
  }
  return static_cast<std::size_t>(count);
}

}  // namespace ilp
