// Eigenvalues and eigenvectors of a small symmetric matrix by cyclic Jacobi rotations (G. Golub, C. Van Loan, "Matrix
// Computations", 8.5): no allocation, bounded, and more accurate for small eigenvalues than tridiagonalisation.
#pragma once

#include <cmath>

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> values;   ///< ascending
  Eigen::Matrix<double, N, N> vectors;  ///< columns, orthonormal
};

/// Both triangles of `matrix` are read. Returns false if it is not finite or the sweeps do not converge.
template <int N>
bool symmetric_eigen(const Eigen::Matrix<double, N, N>& matrix, SymmetricEigen<N>& result) {
  constexpr int max_sweeps = 30;  // convergence is quadratic: ten are plenty
  Eigen::Matrix<double, N, N> a = matrix;
  Eigen::Matrix<double, N, N>& v = result.vectors;
  v.setIdentity();
  const double scale2 = a.squaredNorm();
  if (!std::isfinite(scale2)) return false;
  bool converged = false;
  for (int sweep = 0; sweep < max_sweeps && !converged; ++sweep) {
    double off2 = 0;
    for (int p = 0; p < N; ++p) {
      for (int q = p + 1; q < N; ++q) off2 += a(p, q) * a(p, q);
    }
    converged = off2 <= 1e-36 * scale2;
    if (converged) break;
    for (int p = 0; p < N; ++p) {
      for (int q = p + 1; q < N; ++q) {
        if (a(p, q) == 0) continue;
        const double theta = (a(q, q) - a(p, p)) / (2 * a(p, q));
        const double t = std::copysign(1.0, theta) / (std::fabs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1);
        const double s = t * c;
        for (int k = 0; k < N; ++k) {
          const double kp = a(k, p);
          const double kq = a(k, q);
          a(k, p) = c * kp - s * kq;
          a(k, q) = s * kp + c * kq;
        }
        for (int k = 0; k < N; ++k) {
          const double pk = a(p, k);
          const double qk = a(q, k);
          a(p, k) = c * pk - s * qk;
          a(q, k) = s * pk + c * qk;
        }
        for (int k = 0; k < N; ++k) {
          const double kp = v(k, p);
          const double kq = v(k, q);
          v(k, p) = c * kp - s * kq;
          v(k, q) = s * kp + c * kq;
        }
      }
    }
  }
  result.values = a.diagonal();
  for (int i = 0; i < N; ++i) {
    int smallest = i;
    for (int k = i + 1; k < N; ++k) {
      if (result.values[k] < result.values[smallest]) smallest = k;
    }
    if (smallest == i) continue;
    const double value = result.values[i];
    result.values[i] = result.values[smallest];
    result.values[smallest] = value;
    const Eigen::Matrix<double, N, 1> vector = v.col(i);
    v.col(i) = v.col(smallest);
    v.col(smallest) = vector;
  }
  return converged;
}

}  // namespace ilp
