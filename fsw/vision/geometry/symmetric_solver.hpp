// Solves small symmetric systems of linear equations. Eigen's solver takes seconds to compile for each size, so it is
// compiled only once.
#pragma once

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

/// Solves A x = b by A = P^T L D L^T P with the largest remaining diagonal entry as the next pivot (G. Golub, C. Van
/// Loan, "Matrix Computations", 4.4.3); the lower triangle of A is read. If an entry of D is zero, its unknown is zero.
/// Only the sizes that symmetric_solver.cpp lists exist.
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, 1> solve_symmetric(const Eigen::Matrix<double, N, N>& a,
                                                          const Eigen::Matrix<double, N, 1>& b);
/// The inverse of A, computed by the same factorisation.
template <int N>
[[nodiscard]] Eigen::Matrix<double, N, N> inverse_of_symmetric(const Eigen::Matrix<double, N, N>& a);

}  // namespace ilp
