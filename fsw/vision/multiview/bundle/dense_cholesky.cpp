#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

#include <cmath>

namespace ilp {

bool cholesky_factor(double* a, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) {
    double* row = a + i * n;
    const double diagonal = row[i];
    for (std::size_t j = 0; j < i; ++j) {
      const double* other = a + j * n;
      double sum = row[j];
      for (std::size_t k = 0; k < j; ++k) sum -= row[k] * other[k];
      row[j] = sum / other[j];
    }
    double sum = diagonal;
    for (std::size_t k = 0; k < i; ++k) sum -= row[k] * row[k];
    // Below this share of the diagonal only rounding is left.
    if (!(sum > 1e-15 * diagonal) || !std::isfinite(sum)) return false;
    row[i] = std::sqrt(sum);
  }
  return true;
}

void cholesky_solve_lower(const double* l, std::size_t n, double* x) {
  for (std::size_t i = 0; i < n; ++i) {
    double sum = x[i];
    for (std::size_t k = 0; k < i; ++k) sum -= l[i * n + k] * x[k];
    x[i] = sum / l[i * n + i];
  }
}

void cholesky_solve_upper(const double* l, std::size_t n, double* x) {
  for (std::size_t i = n; i-- > 0;) {
    x[i] /= l[i * n + i];
    for (std::size_t k = 0; k < i; ++k) x[k] -= l[i * n + k] * x[i];
  }
}

void cholesky_solve(const double* l, std::size_t n, double* x) {
  cholesky_solve_lower(l, n, x);
  cholesky_solve_upper(l, n, x);
}

}  // namespace ilp
