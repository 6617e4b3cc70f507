// Relative pose of two calibrated views from five matches: valid on planes, where eight points fail.
#pragma once

#include <cstddef>

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

inline constexpr std::size_t max_five_point_solutions = 10;

/// Writes all real essential matrices with b[i]^T E a[i] = 0, each with Frobenius norm sqrt(2) and arbitrary sign. `a`
/// and `b` are viewing rays (x, y, 1 or unit length) of the two cameras. Returns the number of matrices, 0 if the rays
/// are degenerate or not finite. Source: D. Nister, "An Efficient Solution to the Five-Point Relative Pose Problem",
/// PAMI 2004; the null space by Householder reflections instead of his QR.
std::size_t five_point(const Vec3 a[5], const Vec3 b[5], Mat3 essentials[max_five_point_solutions]);

}  // namespace ilp
