// The prior of a keyframe's registration: its predicted pose on the map, with covariance.
#pragma once

#include "fsw/records/records.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

/// Covariance of a pose if the position of its ground is known better than that of the camera: an error of the tilt
/// moves the camera. `attitude` is the covariance of the attitude in the camera's axes; `variances_m2` are those of the
/// ground's x and y and of the camera's height; `distance_m` is the distance of the ground.
[[nodiscard]] PoseCovariance covariance_over_ground(const Mat3& cam_from_map, double distance_m, const Mat3& attitude,
                                                    const Vec3& variances_m2);

/// Computes the prior from the latest fixes and the poses since. `frame` is estimated from the fixes alone. `way_m` is
/// the length of the camera's track since the newest fix, over which the poses may drift. Returns false if `frame` does
/// not determine the pose.
[[nodiscard]] bool prior_by_fixes(const navigation::StripFrame& frame, const PoseRecord& pose, double way_m,
                                  MapPrior& prior);

/// Computes the prior from the vehicle's measurements: `keyframe` has those at the keyframe, with positions on the
/// map's plane, and `frame` is estimated from the neighbouring keyframes. Position and attitude are those of the
/// keyframe, or else those of the frame. The height above the ground, which is at `ground_m`, comes from the altimeter,
/// the scale of the strip, or the elevation. Returns false if one of them is not known.
[[nodiscard]] bool prior_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe,
                                    double ground_m, MapPrior& prior);
/// Computes only x and y of that prior, for finding the ground.
[[nodiscard]] bool place_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe,
                                    Vec3& place_m, double& sigma_m);

}  // namespace ilp
