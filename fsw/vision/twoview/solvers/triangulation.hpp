// The point nearest to two or more viewing rays, and how reliable it is.
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
/// "Triangulation", CVIU 1997). A point behind a camera is not refined and has in_front false. `numerical_failure` when
/// the rays are parallel (angle below 1e-7 rad) or not finite, `invalid_argument` below two views.
Status triangulate(const RayView* views, std::size_t count, TriangulatedPoint& point);

}  // namespace ilp
