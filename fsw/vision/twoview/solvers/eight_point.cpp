#include "fsw/vision/twoview/solvers/eight_point.hpp"

#include "fsw/vision/twoview/solvers/singular_values.hpp"
#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {

bool eight_point(const NormalisedPairs& pairs, const PairSelection& selection, Mat3& fundamental) {
  if (selection.count < 8) return false;
  using Row = Eigen::Matrix<double, 9, 1>;
  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < selection.count; ++i) {
    const NormalisedPair& p = pairs.exact[selection.indices[i]];
    Row row;
    row << p.xb * p.xa, p.xb * p.ya, p.xb, p.yb * p.xa, p.yb * p.ya, p.yb, p.xa, p.ya, 1;
    normal += row * row.transpose();
  }
  SymmetricEigen<9> eigen;
  if (!symmetric_eigen(normal, eigen)) return false;
  constexpr double ambiguous = 1e-13;  // of the largest: squared rounding errors of the rows
  if (!(eigen.values[1] > ambiguous * eigen.values[8])) return false;
  const Row entries = eigen.vectors.col(0);
  const Mat3 f = Eigen::Map<const Mat3>(entries.data()).transpose();
  SingularValues svd;
  if (!singular_values(f, svd)) return false;
  svd.values[2] = 0;
  fundamental = svd.u * svd.values.asDiagonal() * svd.v.transpose();
  return true;
}

}  // namespace ilp
