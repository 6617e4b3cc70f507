// Computes where a camera's line of sight meets the ground of a map, and the covariance of that point.
#pragma once

#include "fsw/vision/map/map_window.hpp"

namespace ilp {

/// Intersects a line of sight (`direction` in the camera frame) with level ground at the height `ground_m`. Returns
/// false if the camera is not above that ground, or if the direction is less than 3 degrees below the horizon.
[[nodiscard]] bool ground_on_level(const RigidTransform& camera_from_map, const Vec3& direction, double ground_m,
                                   Vec3& ground);
/// Height of the window's ground, interpolated bilinearly. Unknown cells have the height MapWindow::ground_m. Beyond
/// the border, the height is that of the border.
[[nodiscard]] double height_at(const MapWindow& window, double x_m, double y_m);
/// Intersects the optical axis with the window's ground, starting from the height `ground_m`. Returns false as
/// ground_on_level().
[[nodiscard]] bool ground_on_axis(const RigidTransform& camera_from_map, const MapWindow& window, double ground_m,
                                  Vec3& ground);

/// Derivatives of x and y of the point `ground`, which stays on level ground in the same line of sight, with respect to
/// a small change of the pose (MapPrior).
[[nodiscard]] Eigen::Matrix<double, 2, 6> ground_by_pose(const RigidTransform& camera_from_map, const Vec3& ground);
/// Covariance of x and y of this point, m^2, for the covariance of the pose.
[[nodiscard]] Mat2 ground_covariance(const RigidTransform& camera_from_map, const Vec3& ground,
                                     const PoseCovariance& covariance);
/// The larger semi-axis of the one-sigma ellipse.
[[nodiscard]] double largest_sigma(const Mat2& covariance);

}  // namespace ilp
