// Fundamental matrices through seven matches: the minimal sample of the uncalibrated robust estimator.
#pragma once

#include <cstddef>

#include "fsw/vision/geometry/types.hpp"

namespace ilp {

inline constexpr std::size_t max_seven_point_solutions = 3;

/// All real rank-two F with b[i]^T F a[i] = 0, of unit norm: the roots of det(F1 + z F2) = 0 (R. Hartley, A. Zisserman,
/// "Multiple View Geometry", 11.1.2). Returns their number, 0 if the matches are dependent or not finite. `a` and `b`
/// are (x, y, 1) in normalised coordinates.
std::size_t seven_point(const Vec3 a[7], const Vec3 b[7], Mat3 fundamentals[max_seven_point_solutions]);

}  // namespace ilp
