// The pose of a calibrated camera from three points (M. Persson, K. Nordberg, "Lambda Twist: An Accurate Fast Robust
// Perspective Three Point (P3P) Solver", ECCV 2018).
#pragma once

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

inline constexpr int max_p3p_solutions = 4;

/// Solves for the camera pose. `bearing[i]` is the unit vector, in the camera frame, towards the world point
/// `point[i]`. Returns the number of solutions in `cam_from_world`, all with the points in front of the camera; 0 if
/// the points are collinear or the view is degenerate.
[[nodiscard]] int solve_p3p(const Vec3 bearing[3], const Vec3 point[3],
                            RigidTransform cam_from_world[max_p3p_solutions]);

}  // namespace ilp
