// The pose of a camera from places of a map that it sees: Gauss-Newton over the six unknowns of MapPrior with Huber
// weights, and with the prior's attitude where the vehicle measured it.
#pragma once

#include <span>

#include "fsw/vision/map/map_window.hpp"

namespace ilp {

struct MapSighting {
  Vec3 place = Vec3::Zero();     ///< in the map, m
  Vec2 at = Vec2::Zero();        ///< in the camera: x / z, y / z
  double weight = 1;             ///< of the last step; 0: left out
  Vec2 residual = Vec2::Zero();  ///< at that pose, in working px
};

struct MapPoseParams {
  double pixel_m = 1;         ///< the working pixel
  double sigma_px = 0.1;      ///< of a sighting, at least; working px
  double together = 1.6;      ///< the spread of the residuals is this much too small: neighbours err together
  double common_share = 0.5;  ///< error of all together over the spread: a map that fits worse is off as a whole, too
  double common_growth = 0;   ///< the same, for each px of the spread
};

struct MapPose {
  RigidTransform camera_from_map;
  PoseCovariance covariance = PoseCovariance::Zero();
  double residual_px = 0;  ///< root mean square of the sightings with weight, per axis
  std::int32_t used = 0;
};

/// Residual of a sighting, in units at / distance 1, and its derivatives by a small change of the pose. False behind
/// the camera.
[[nodiscard]] bool sighting_residual(const RigidTransform& camera_from_map, const MapSighting& sighting, Vec2& residual,
                                     Eigen::Matrix<double, 2, 6>& by_pose);
/// The pose after a small change.
[[nodiscard]] RigidTransform changed_pose(const RigidTransform& camera_from_map,
                                          const Eigen::Matrix<double, 6, 1>& change);
/// The change from one pose to another.
[[nodiscard]] Eigen::Matrix<double, 6, 1> pose_change(const RigidTransform& from, const RigidTransform& to);
/// False when the sightings do not determine a pose.
[[nodiscard]] bool solve_map_pose(std::span<MapSighting> sightings, const MapPrior& prior, const MapPoseParams& params,
                                  MapPose& pose);

/// Inverse of a symmetric positive definite matrix. False when it is none.
template <int N>
[[nodiscard]] bool invert_positive_definite(const Eigen::Matrix<double, N, N>& matrix,
                                            Eigen::Matrix<double, N, N>& inverted);

}  // namespace ilp
