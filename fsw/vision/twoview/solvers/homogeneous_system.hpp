// Many homogeneous linear equations in the nine entries of a 3x3 matrix.
#pragma once

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

class HomogeneousSystem {
 public:
  /// The products of `row` with the entries of the matrix, row by row, should sum up to zero.
  void add(const double (&row)[9]);
  /// The matrix of unit norm with the least sum of squared errors, up to sign. False when the equations leave more than
  /// one.
  bool solve(Mat3& matrix) const;

 private:
  Eigen::Matrix<double, 9, 9> normal_ = Eigen::Matrix<double, 9, 9>::Zero();
};

}  // namespace ilp
