// The fixed-size linear algebra types of the vision kernels.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>  // cross products

namespace ilp {

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;
using Vec4 = Eigen::Vector4d;
using Mat3 = Eigen::Matrix3d;
using Mat34 = Eigen::Matrix<double, 3, 4>;

/// The vector of three numbers of a record.
[[nodiscard]] inline Vec3 vector_of(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

}  // namespace ilp
