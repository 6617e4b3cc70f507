// Cholesky factorisation for the few unknowns of a registration or a patch refinement.
#pragma once

#include <cmath>

namespace ilp {

/// Replaces the lower triangle of the symmetric positive definite matrix A by its factor L, A = L L^T. Returns false
/// and leaves A undefined if a pivot falls below `tolerance` times its diagonal element: then the unknowns are not
/// independent.
template <int N, typename Real>
[[nodiscard]] bool factor_positive_definite(Real (&a)[N][N], Real tolerance) {
  for (int j = 0; j < N; ++j) {
    Real pivot = a[j][j];
    for (int k = 0; k < j; ++k) pivot -= a[j][k] * a[j][k];
    if (!(pivot > tolerance * a[j][j])) return false;
    a[j][j] = std::sqrt(pivot);
    for (int i = j + 1; i < N; ++i) {
      Real sum = a[i][j];
      for (int k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      a[i][j] = sum / a[j][j];
    }
  }
  return true;
}

/// Solves L L^T x = b in place.
template <int N, typename Real>
void solve_factored(const Real (&factor)[N][N], Real (&b)[N]) {
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < i; ++k) b[i] -= factor[i][k] * b[k];
    b[i] /= factor[i][i];
  }
  for (int i = N - 1; i >= 0; --i) {
    for (int k = i + 1; k < N; ++k) b[i] -= factor[k][i] * b[k];
    b[i] /= factor[i][i];
  }
}

/// Returns element (i, i) of the inverse of A, computed from its factor.
template <int N, typename Real>
[[nodiscard]] Real inverse_diagonal(const Real (&factor)[N][N], int i) {
  // A^-1 = L^-T L^-1, so its diagonal is the squared norm of column i of L^-1.
  Real column[N] = {};
  Real sum = 0;
  for (int r = i; r < N; ++r) {
    Real value = r == i ? Real(1) : Real(0);
    for (int k = i; k < r; ++k) value -= factor[r][k] * column[k];
    column[r] = value / factor[r][r];
    sum += column[r] * column[r];
  }
  return sum;
}

}  // namespace ilp
