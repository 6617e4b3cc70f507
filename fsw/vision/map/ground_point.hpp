// Where a camera's line of sight meets the ground of a map, and how well that is known.
#pragma once

#include "fsw/vision/map/map_window.hpp"

namespace ilp {

/// Meets the level ground at this height. False when the direction (in the camera) does not lead down to it.
[[nodiscard]] bool ground_on_level(const RigidTransform& camera_from_map, const Vec3& direction, double ground_m,
                                   Vec3& ground);
/// Height of the window's ground, bilinear between cells, MapWindow::ground_m in those that are unknown; beyond the
/// border that of the border.
[[nodiscard]] double height_at(const MapWindow& window, double x_m, double y_m);
/// Where the optical axis meets the window's ground, beginning at `ground_m`. False as above.
[[nodiscard]] bool ground_on_axis(const RigidTransform& camera_from_map, const MapWindow& window, double ground_m,
                                  Vec3& ground);

/// Derivatives of x and y, on level ground, of the place that is seen at `ground`, by a small change of the pose
/// (MapPrior).
[[nodiscard]] Eigen::Matrix<double, 2, 6> ground_by_pose(const RigidTransform& camera_from_map, const Vec3& ground);
[[nodiscard]] Mat2 ground_covariance(const RigidTransform& camera_from_map, const Vec3& ground,
                                     const PoseCovariance& covariance);
/// The larger half axis of the ellipse of one standard deviation.
[[nodiscard]] double largest_sigma(const Mat2& covariance);

}  // namespace ilp
