// Small symmetric systems of linear equations. Eigen's own solver takes the compiler seconds for every size.
#pragma once

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

inline constexpr int max_symmetric_system = 8;

/// Solves A x = b by A = P^T L D L^T P with the largest remaining diagonal entry as the next pivot (G. Golub, C. Van
/// Loan, "Matrix Computations", 4.4.3). `a` holds A column by column; its lower triangle is read and overwritten. `b`
/// becomes x. An entry of D that is zero makes its unknown zero. Sums have a fixed order, which is that of Eigen's
/// LDLT.
void solve_symmetric(double* a, int size, double* b);

template <int N>
[[nodiscard]] Eigen::Matrix<double, N, 1> solve_symmetric(Eigen::Matrix<double, N, N> a,
                                                          Eigen::Matrix<double, N, 1> b) {
  static_assert(N <= max_symmetric_system);
  solve_symmetric(a.data(), N, b.data());
  return b;
}

}  // namespace ilp
