// Solves a small symmetric system of equations in the unknowns of a camera.
#pragma once

#include "fsw/vision/calibration/intrinsics_equations.hpp"
#include "fsw/vision/multiview/bundle/dense_cholesky.hpp"

namespace ilp {

struct CameraSystem {
  std::array<double, camera_unknowns * camera_unknowns> matrix{};  ///< row by row; after factor(): its Cholesky factor

  double& at(std::size_t row, std::size_t column) { return matrix[row * camera_unknowns + column]; }
  /// Returns false if the matrix is not positive definite.
  [[nodiscard]] bool factor() { return cholesky_factor(matrix.data(), camera_unknowns); }
  [[nodiscard]] CameraUnknowns solve(CameraUnknowns right) const {
    cholesky_solve(matrix.data(), camera_unknowns, right.data());
    return right;
  }
  [[nodiscard]] CameraUnknowns column_of_inverse(std::size_t column) const {
    CameraUnknowns unit{};
    unit[column] = 1;
    return solve(unit);
  }
};

}  // namespace ilp
