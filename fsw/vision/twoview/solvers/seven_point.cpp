#include "fsw/vision/twoview/solvers/seven_point.hpp"

#include <Eigen/LU>
#include <cmath>

#include "fsw/vision/twoview/solvers/cubic_roots.hpp"
#include "fsw/vision/twoview/solvers/null_space.hpp"

namespace ilp {
namespace {

double triple(const Vec3& a, const Vec3& b, const Vec3& c) {
  return a.dot(b.cross(c));
}

/// Two independent solutions of seven equations in nine unknowns, by elimination with the largest entry of a row as its
/// pivot. False when an equation depends on the others, or is not finite. `rows` is overwritten.
bool two_solutions(double (&rows)[7][9], double (&solutions)[2][9]) {
  int pivots[7];
  bool taken[9] = {};
  for (int i = 0; i < 7; ++i) {
    int pivot = 0;
    for (int k = 1; k < 9; ++k) pivot = std::fabs(rows[i][k]) > std::fabs(rows[i][pivot]) ? k : pivot;
    const double inverse = 1 / rows[i][pivot];
    if (!(std::fabs(rows[i][pivot]) > 1e-10) || !std::isfinite(inverse) || taken[pivot]) return false;
    for (double& x : rows[i]) x *= inverse;
    for (int j = i + 1; j < 7; ++j) {
      const double factor = rows[j][pivot];
      for (int k = 0; k < 9; ++k) rows[j][k] -= factor * rows[i][k];
      rows[j][pivot] = 0;
    }
    pivots[i] = pivot;
    taken[pivot] = true;
  }
  // The two unknowns without pivot are set to (cos, sin) and (-sin, cos) of an angle. With (1, 0) and (0, 1) the second
  // solution alone would represent motions along a line, and no multiple of it added to the first would reach them.
  constexpr double free_values[2][2] = {{0.8, 0.6}, {-0.6, 0.8}};
  for (int n = 0; n < 2; ++n) {
    double* const x = solutions[n];
    for (int k = 0, next = 0; k < 9; ++k) x[k] = taken[k] ? 0 : free_values[n][next++];
    for (int i = 6; i >= 0; --i) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) sum += rows[i][k] * x[k];
      x[pivots[i]] = -sum;
    }
  }
  return true;
}

}  // namespace

std::size_t seven_point(const Vec3 a[7], const Vec3 b[7], Mat3 fundamentals[max_seven_point_solutions]) {
  double equations[7][9];
  epipolar_equations(a, b, equations);
  double basis[2][9];
  if (!two_solutions(equations, basis)) return 0;

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
  double roots[3];
  const int count = cubic_roots(cubic, roots);
  for (int k = 0; k < count; ++k) {
    for (int i = 0; i < 9; ++i) fundamentals[k](i / 3, i % 3) = basis[0][i] + roots[k] * basis[1][i];
    fundamentals[k].normalize();
  }
  return static_cast<std::size_t>(count);
}

}  // namespace ilp
