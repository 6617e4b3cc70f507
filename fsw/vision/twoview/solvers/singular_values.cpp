#include "fsw/vision/twoview/solvers/singular_values.hpp"

#include <cmath>

#include "fsw/vision/twoview/solvers/symmetric_eigen.hpp"

namespace ilp {

bool singular_values(const Mat3& matrix, SingularValues& svd) {
  const double norm = matrix.norm();
  if (!(norm > 0) || !std::isfinite(norm)) return false;
  const Mat3 m = matrix / norm;
  SymmetricEigen<3> eigen;
  if (!symmetric_eigen<3>(m.transpose() * m, eigen)) return false;
  svd.v.col(0) = eigen.vectors.col(2);
  svd.v.col(1) = eigen.vectors.col(1);
  svd.v.col(2) = svd.v.col(0).cross(svd.v.col(1));
  const Vec3 first = m * svd.v.col(0);
  Vec3 second = m * svd.v.col(1);
  svd.u.col(0) = first.normalized();
  second -= svd.u.col(0) * svd.u.col(0).dot(second);
  if (!(second.norm() > 1e-9)) return false;
  svd.u.col(1) = second.normalized();
  svd.u.col(2) = svd.u.col(0).cross(svd.u.col(1));
  svd.values = norm * Vec3(first.norm(), second.norm(), svd.u.col(2).dot(m * svd.v.col(2)));
  return svd.u.allFinite() && svd.v.allFinite();
}

}  // namespace ilp
