// Triangulates a point from two or more views, and measures how reliable it is.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// One view of a point: normalised image coordinates and the camera.
struct RayView {
  Vec2 normalised;
  RigidTransform cam_from_world;
};

struct TriangulatedPoint {
  Vec3 position = Vec3::Zero();  ///< world
  double angle_rad = 0;          ///< largest angle between two rays
  double max_error = 0;          ///< largest reprojection error, normalised units
  bool in_front = false;         ///< positive depth in every view
};

/// Starts from the midpoint of all rays and refines it by Gauss-Newton on the reprojection error (R. Hartley, P. Sturm,
/// "Triangulation", CVIU 1997). A point behind a camera is not refined and has in_front false. Returns
/// `numerical_failure` if the rays are parallel (angle below 1e-7 rad) or not finite, `invalid_argument` if there are
/// fewer than two views.
Status triangulate(const RayView* views, std::size_t count, TriangulatedPoint& point);

}  // namespace ilp
