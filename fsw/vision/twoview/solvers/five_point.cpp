#include "fsw/vision/twoview/solvers/five_point.hpp"

#include <cmath>
#include <utility>

#include "fsw/vision/twoview/solvers/null_space.hpp"
#include "fsw/vision/twoview/solvers/polynomial_roots.hpp"

namespace ilp {
namespace {

// E = x X + y Y + z Z + W. Polynomials in x, y, z hold their coefficients in the orders
//   Linear:    x, y, z, 1
//   Quadratic: x2, xy, y2, xz, yz, z2, x, y, z, 1
//   Cubic:     x3, y3, x2y, xy2, x2z, x2, y2z, y2, xyz, xy, xz2, xz, x, yz2, yz, y, z3, z2, z, 1   (Nister, eq. 11)
struct Linear {
  double c[4];
};
struct Quadratic {
  double c[10];
};
struct Cubic {
  double c[20];
};

void add_product(const Linear& p, const Linear& q, double factor, Quadratic& sum) {
  const double a[4] = {factor * p.c[0], factor * p.c[1], factor * p.c[2], factor * p.c[3]};
  const double* b = q.c;
  sum.c[0] += a[0] * b[0];
  sum.c[1] += a[0] * b[1] + a[1] * b[0];
  sum.c[2] += a[1] * b[1];
  sum.c[3] += a[0] * b[2] + a[2] * b[0];
  sum.c[4] += a[1] * b[2] + a[2] * b[1];
  sum.c[5] += a[2] * b[2];
  sum.c[6] += a[0] * b[3] + a[3] * b[0];
  sum.c[7] += a[1] * b[3] + a[3] * b[1];
  sum.c[8] += a[2] * b[3] + a[3] * b[2];
  sum.c[9] += a[3] * b[3];
}

void add_product(const Quadratic& p, const Linear& q, double* sum) {
  const double* a = p.c;
  const double* b = q.c;
  sum[0] += a[0] * b[0];
  sum[1] += a[2] * b[1];
  sum[2] += a[0] * b[1] + a[1] * b[0];
  sum[3] += a[1] * b[1] + a[2] * b[0];
  sum[4] += a[0] * b[2] + a[3] * b[0];
  sum[5] += a[0] * b[3] + a[6] * b[0];
  sum[6] += a[2] * b[2] + a[4] * b[1];
  sum[7] += a[2] * b[3] + a[7] * b[1];
  sum[8] += a[1] * b[2] + a[3] * b[1] + a[4] * b[0];
  sum[9] += a[1] * b[3] + a[6] * b[1] + a[7] * b[0];
  sum[10] += a[3] * b[2] + a[5] * b[0];
  sum[11] += a[3] * b[3] + a[6] * b[2] + a[8] * b[0];
  sum[12] += a[6] * b[3] + a[9] * b[0];
  sum[13] += a[4] * b[2] + a[5] * b[1];
  sum[14] += a[4] * b[3] + a[7] * b[2] + a[8] * b[1];
  sum[15] += a[7] * b[3] + a[9] * b[1];
  sum[16] += a[5] * b[2];
  sum[17] += a[5] * b[3] + a[8] * b[2];
  sum[18] += a[8] * b[3] + a[9] * b[2];
  sum[19] += a[9] * b[3];
}

struct Constraints {
  double row[10][20];
};

/// Nine rows of (E E^T - trace(E E^T)/2 I) E = 0, one of det E = 0.
void build_constraints(const Linear (&e)[3][3], Constraints& constraints) {
  constraints = {};
  Quadratic lambda[3][3] = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) add_product(e[i][k], e[j][k], 1, lambda[i][j]);
    }
  }
  for (int c = 0; c < 10; ++c) {
    const double half_trace = 0.5 * (lambda[0][0].c[c] + lambda[1][1].c[c] + lambda[2][2].c[c]);
    for (int i = 0; i < 3; ++i) lambda[i][i].c[c] -= half_trace;
  }
  lambda[1][0] = lambda[0][1];
  lambda[2][0] = lambda[0][2];
  lambda[2][1] = lambda[1][2];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) add_product(lambda[i][k], e[k][j], constraints.row[3 * i + j]);
    }
  }
  for (int j = 0; j < 3; ++j) {
    const int k = (j + 1) % 3;
    const int l = (j + 2) % 3;
    Quadratic minor = {};
    add_product(e[1][k], e[2][l], 1, minor);
    add_product(e[1][l], e[2][k], -1, minor);
    add_product(minor, e[0][j], constraints.row[9]);
  }
}

/// Gauss-Jordan on the first ten columns with row pivoting; only the last six rows are needed fully reduced.
bool eliminate(Constraints& constraints) {
  auto& m = constraints.row;
  for (int column = 0; column < 10; ++column) {
    int pivot = column;
    for (int r = column + 1; r < 10; ++r) {
      if (std::fabs(m[r][column]) > std::fabs(m[pivot][column])) pivot = r;
    }
    if (!(std::fabs(m[pivot][column]) > 1e-12)) return false;
    if (pivot != column) {
      for (int c = column; c < 20; ++c) std::swap(m[pivot][c], m[column][c]);
    }
    const double inverse = 1 / m[column][column];
    for (int c = column; c < 20; ++c) m[column][c] *= inverse;
    for (int r = column < 4 ? column + 1 : 4; r < 10; ++r) {
      if (r == column) continue;
      const double factor = m[r][column];
      for (int c = column; c < 20; ++c) m[r][c] -= factor * m[column][c];
    }
  }
  return true;
}

/// Coefficients of powers of z, ascending; entries 0 and 1 of a row multiply x and y and have degree 3, entry 2 has
/// degree 4.
struct RowInZ {
  double c[3][5];
};

/// <upper> - z <lower>, with leading monomials m z and m (Nister, eq. 12 to 14).
RowInZ subtract(const double* upper, const double* lower) {
  RowInZ row = {};
  for (int block = 0; block < 2; ++block) {
    const double* u = &upper[10 + 3 * block];
    const double* l = &lower[10 + 3 * block];
    row.c[block][3] = -l[0];
    row.c[block][2] = u[0] - l[1];
    row.c[block][1] = u[1] - l[2];
    row.c[block][0] = u[2];
  }
  row.c[2][4] = -lower[16];
  row.c[2][3] = upper[16] - lower[17];
  row.c[2][2] = upper[17] - lower[18];
  row.c[2][1] = upper[18] - lower[19];
  row.c[2][0] = upper[19];
  return row;
}

template <int P, int Q>
void add_product(const double* p, const double* q, double sign, double* sum) {
  for (int i = 0; i <= P; ++i) {
    for (int j = 0; j <= Q; ++j) sum[i + j] += sign * p[i] * q[j];
  }
}

/// Determinant of the three rows: the tenth degree polynomial in z.
void determinant(const RowInZ (&b)[3], double (&polynomial)[11]) {
  for (double& c : polynomial) c = 0;
  for (int i = 0; i < 3; ++i) {
    const RowInZ& second = b[(i + 1) % 3];
    const RowInZ& third = b[(i + 2) % 3];
    double minor[7] = {};
    add_product<3, 3>(second.c[0], third.c[1], 1, minor);
    add_product<3, 3>(second.c[1], third.c[0], -1, minor);
    add_product<6, 4>(minor, b[i].c[2], 1, polynomial);
  }
}

double evaluate(const double* c, int degree, double z) {
  double value = c[degree];
  for (int k = degree - 1; k >= 0; --k) value = value * z + c[k];
  return value;
}

/// x and y from the two rows that determine them best.
bool solve_xy(const RowInZ (&b)[3], double z, double& x, double& y) {
  Vec3 rows[3];
  for (int i = 0; i < 3; ++i) {
    rows[i] = Vec3(evaluate(b[i].c[0], 3, z), evaluate(b[i].c[1], 3, z), evaluate(b[i].c[2], 4, z));
  }
  Vec3 best = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Vec3 candidate = rows[i].cross(rows[(i + 1) % 3]);
    if (candidate.squaredNorm() > best.squaredNorm()) best = candidate;
  }
  if (!(std::fabs(best.z()) > 1e-12 * best.norm())) return false;
  x = best.x() / best.z();
  y = best.y() / best.z();
  return true;
}

}  // namespace

std::size_t five_point(const Vec3 a[5], const Vec3 b[5], Mat3 essentials[max_five_point_solutions]) {
  double equations[5][9];
  epipolar_equations(a, b, equations);
  double basis[4][9];
  if (!null_space<5>(equations, basis)) return 0;

  Linear e[3][3];
  for (int k = 0; k < 4; ++k) {
    for (int i = 0; i < 9; ++i) e[i / 3][i % 3].c[k] = basis[k][i];
  }
  Constraints constraints;
  build_constraints(e, constraints);
  if (!eliminate(constraints)) return 0;

  const auto& m = constraints.row;
  const RowInZ rows[3] = {subtract(m[4], m[5]), subtract(m[6], m[7]), subtract(m[8], m[9])};
  double polynomial[11];
  determinant(rows, polynomial);
  RealRoots<10> solver;
  double roots[10];
  const int root_count = solver.find(polynomial, roots);

  std::size_t count = 0;
  for (int i = 0; i < root_count; ++i) {
    const double z = roots[i];
    double x = 0;
    double y = 0;
    if (!solve_xy(rows, z, x, y)) continue;
    Mat3& essential = essentials[count];
    for (int k = 0; k < 9; ++k) {
      essential(k / 3, k % 3) = x * basis[0][k] + y * basis[1][k] + z * basis[2][k] + basis[3][k];
    }
    const double norm = essential.norm();
    if (!(norm > 0) || !std::isfinite(norm)) continue;
    essential *= std::sqrt(2.0) / norm;
    ++count;
  }
  return count;
}

}  // namespace ilp
