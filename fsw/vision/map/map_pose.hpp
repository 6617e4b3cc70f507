// Estimates the pose of a camera from points of a map that it sees: Gauss-Newton over the six unknowns of MapPrior with
// Huber weights. The prior's attitude is an observation if the vehicle measured it.
#pragma once

#include <span>

#include "fsw/vision/map/map_window.hpp"

namespace ilp {

struct MapSighting {
  Vec3 place = Vec3::Zero();     ///< map frame, m
  Vec2 at = Vec2::Zero();        ///< normalised coordinates in the camera: x / z, y / z
  double weight = 1;             ///< weight in the last step; 0: left out as an outlier
  Vec2 residual = Vec2::Zero();  ///< at the estimated pose, working px
};

struct MapPoseParams {
  double pixel_m = 1;     ///< the working pixel
  double sigma_px = 0.1;  ///< least standard deviation of a sighting, working px
  double together = 1.6;  ///< factor by which the residuals understate the errors: those of neighbours are correlated
  double common_share = 0.5;  ///< error common to all sightings, as a share of the RMS residual
  double common_growth = 0;   ///< increase of this share per px of the RMS residual, 1/px
};

struct MapPose {
  RigidTransform camera_from_map;
  PoseCovariance covariance = PoseCovariance::Zero();
  double residual_px = 0;  ///< RMS residual per axis of the sightings with weight, working px
  std::int32_t used = 0;   ///< sightings with weight
};

/// Residual of a sighting in normalised coordinates, and its derivatives with respect to a small change of the pose
/// (MapPrior). Returns false if the point is behind the camera.
[[nodiscard]] bool sighting_residual(const RigidTransform& camera_from_map, const MapSighting& sighting, Vec2& residual,
                                     Eigen::Matrix<double, 2, 6>& by_pose);
/// The pose after a small change (MapPrior).
[[nodiscard]] RigidTransform changed_pose(const RigidTransform& camera_from_map,
                                          const Eigen::Matrix<double, 6, 1>& change);
/// The change from one pose to another.
[[nodiscard]] Eigen::Matrix<double, 6, 1> pose_change(const RigidTransform& from, const RigidTransform& to);
/// Estimates the pose, starting from the prior, and writes weight and residual of each sighting. `sightings` must not
/// be empty. Returns false if they do not determine a pose.
[[nodiscard]] bool solve_map_pose(std::span<MapSighting> sightings, const MapPrior& prior, const MapPoseParams& params,
                                  MapPose& pose);

/// Inverts a symmetric matrix. Returns false if it is not positive definite.
template <int N>
[[nodiscard]] bool invert_positive_definite(const Eigen::Matrix<double, N, N>& matrix,
                                            Eigen::Matrix<double, N, N>& inverted);

}  // namespace ilp
