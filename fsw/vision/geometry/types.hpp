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

}  // namespace ilp
