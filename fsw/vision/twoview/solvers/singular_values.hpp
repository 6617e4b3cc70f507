// Singular value decomposition of a 3x3 matrix of rank two or three, with proper rotations.
#pragma once

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

/// matrix = u diag(values) v^T with det u = det v = +1 and |values| descending; the last value has the sign of the
/// determinant.
struct SingularValues {
  Mat3 u = Mat3::Identity();
  Mat3 v = Mat3::Identity();
  Vec3 values = Vec3::Zero();
};

/// Returns false if the matrix is not finite or its rank is below two.
bool singular_values(const Mat3& matrix, SingularValues& svd);

}  // namespace ilp
