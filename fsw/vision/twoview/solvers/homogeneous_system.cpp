#include "fsw/vision/twoview/solvers/homogeneous_system.hpp"

#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {

void HomogeneousSystem::add(const double (&row)[9]) {
  for (int r = 0; r < 9; ++r) {
    for (int c = 0; c < 9; ++c) normal_(r, c) += row[r] * row[c];
  }
}

bool HomogeneousSystem::solve(Mat3& matrix) const {
  SymmetricEigen<9> eigen;
  if (!symmetric_eigen(normal_, eigen)) return false;
  constexpr double ambiguous = 1e-13;  // of the largest: squared rounding errors of the rows
  if (!(eigen.values[1] > ambiguous * eigen.values[8])) return false;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = eigen.vectors(i, 0);
  return true;
}

}  // namespace ilp
