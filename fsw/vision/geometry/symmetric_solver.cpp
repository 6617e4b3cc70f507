#include "fsw/vision/geometry/symmetric_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp {
namespace {

/// Sum of up to seven values, by halves.
double sum_by_halves(const double* v, int count) {
  switch (count) {
    case 1:
      return v[0];
    case 2:
      return v[0] + v[1];
    case 3:
      return v[0] + (v[1] + v[2]);
    case 4:
      return (v[0] + v[1]) + (v[2] + v[3]);
    case 5:
      return (v[0] + v[1]) + (v[2] + (v[3] + v[4]));
    case 6:
      return (v[0] + (v[1] + v[2])) + (v[3] + (v[4] + v[5]));
    default:
      return (v[0] + (v[1] + v[2])) + ((v[3] + v[4]) + (v[5] + v[6]));
  }
}

struct LowerTriangle {
  double* data;
  int size;

  double& operator()(int row, int column) const { return data[column * size + row]; }

  /// Exchanges rows and columns p < q of the symmetric matrix.
  void swap(int p, int q) const {
    for (int k = 0; k < p; ++k) std::swap((*this)(p, k), (*this)(q, k));
    for (int k = q + 1; k < size; ++k) std::swap((*this)(k, p), (*this)(k, q));
    std::swap((*this)(p, p), (*this)(q, q));
    for (int k = p + 1; k < q; ++k) std::swap((*this)(k, p), (*this)(q, k));
  }
};

/// Replaces A by L below the diagonal and D on it; `pivots[k]` was exchanged with k. False when A is zero.
bool factor(const LowerTriangle& m, int (&pivots)[max_symmetric_system]) {
  for (int k = 0; k < m.size; ++k) {
    int largest = k;
    for (int i = k + 1; i < m.size; ++i) largest = std::fabs(m(i, i)) > std::fabs(m(largest, largest)) ? i : largest;
    pivots[k] = largest;
    if (largest != k) m.swap(k, largest);
    double scaled[max_symmetric_system];
    for (int j = 0; j < k; ++j) scaled[j] = m(j, j) * m(k, j);
    for (int i = k; k > 0 && i < m.size; ++i) {
      double sum = m(i, 0) * scaled[0];
      for (int j = 1; j < k; ++j) sum += m(i, j) * scaled[j];
      m(i, k) -= sum;
    }
    const double pivot = m(k, k);
    if (k == 0 && !(std::fabs(pivot) > 0)) return false;
    for (int i = k + 1; std::fabs(pivot) > 0 && i < m.size; ++i) m(i, k) /= pivot;
  }
  return true;
}

}  // namespace

void solve_symmetric(double* a, int size, double* b) {
  const LowerTriangle m{a, size};
  int pivots[max_symmetric_system] = {0, 1, 2, 3, 4, 5, 6, 7};
  static_cast<void>(factor(m, pivots));
  for (int k = 0; k < size; ++k) std::swap(b[k], b[pivots[k]]);
  double products[max_symmetric_system] = {};
  for (int i = 1; i < size; ++i) {
    for (int j = 0; j < i; ++j) products[j] = m(i, j) * b[j];
    b[i] -= sum_by_halves(products, i);
  }
  for (int i = 0; i < size; ++i) {
    const bool nonzero = std::fabs(m(i, i)) > std::numeric_limits<double>::min();
    b[i] = nonzero ? b[i] / m(i, i) : 0;
  }
  for (int i = size - 2; i >= 0; --i) {
    const int count = size - 1 - i;
    for (int j = 0; j < count; ++j) products[j] = m(i + 1 + j, i) * b[i + 1 + j];
    b[i] -= sum_by_halves(products, count);
  }
  for (int k = size - 1; k >= 0; --k) std::swap(b[k], b[pivots[k]]);
}

}  // namespace ilp
