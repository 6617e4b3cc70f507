// Computes the null space of a few linear equations in nine unknowns (the entries of a 3x3 matrix).
#pragma once

#include <cmath>

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

/// Writes b[i]^T M a[i] = 0 as linear equations in the entries of M (row-major).
template <int Rows>
void epipolar_equations(const Vec3* a, const Vec3* b, double (&equations)[Rows][9]) {
  for (int i = 0; i < Rows; ++i) {
    for (int k = 0; k < 9; ++k) equations[i][k] = b[i][k / 3] * a[i][k % 3];
  }
}

/// Orthonormal basis of the vectors orthogonal to all `Rows` equations: the last columns of Q in the QR decomposition
/// of the transposed equations, by Householder reflections. Returns false if the equations are linearly dependent or
/// not finite.
template <int Rows>
bool null_space(const double (&equations)[Rows][9], double (&basis)[9 - Rows][9]) {
  double work[Rows][9];
  double reflector[Rows][9];
  for (int i = 0; i < Rows; ++i) {
    for (int k = 0; k < 9; ++k) work[i][k] = equations[i][k];
  }
  const auto reflect = [](const double* v, int first, double* x) {
    double dot = 0;
    for (int k = first; k < 9; ++k) dot += v[k] * x[k];
    for (int k = first; k < 9; ++k) x[k] -= dot * v[k];
  };
  for (int i = 0; i < Rows; ++i) {
    double* v = reflector[i];
    double norm2 = 0;
    for (int k = i; k < 9; ++k) norm2 += work[i][k] * work[i][k];
    const double norm = std::sqrt(norm2);
    if (!(norm > 1e-10) || !std::isfinite(norm)) return false;
    const double head = work[i][i] + std::copysign(norm, work[i][i]);
    // Scaled so that the reflection is x - v (v . x): |v|^2 = 2.
    const double scale = std::sqrt(2 / (norm2 - work[i][i] * work[i][i] + head * head));
    v[i] = head * scale;
    for (int k = i + 1; k < 9; ++k) v[k] = work[i][k] * scale;
    for (int j = i + 1; j < Rows; ++j) reflect(v, i, work[j]);
  }
  for (int n = 0; n < 9 - Rows; ++n) {
    for (int k = 0; k < 9; ++k) basis[n][k] = k == Rows + n ? 1.0 : 0.0;
    for (int i = Rows - 1; i >= 0; --i) reflect(reflector[i], i, basis[n]);
  }
  // A last reflection mixes the basis. Without it a vector of the basis tends to stand for one entry of the matrix, and
  // solvers that divide by its coefficient lose the matrices in which motion along a line makes that entry zero.
  constexpr double mirror[9] = {0.62, -0.41, 0.53, -0.71, 0.37, -0.47, 0.59, -0.43, 0.67};
  constexpr int dimension = 9 - Rows;
  double length2 = 0;
  for (int n = 0; n < dimension; ++n) length2 += mirror[n] * mirror[n];
  for (int k = 0; k < 9; ++k) {
    double dot = 0;
    for (int n = 0; n < dimension; ++n) dot += mirror[n] * basis[n][k];
    for (int n = 0; n < dimension; ++n) basis[n][k] -= 2 * dot / length2 * mirror[n];
  }
  return true;
}

}  // namespace ilp
