// Where a keyframe stands on the map before it is registered, and how well that is known.
#pragma once

#include "fsw/records/records.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp {

/// Covariance of a pose whose ground is known, so that a tilt moves the camera: that of the attitude in the camera's
/// axes, and variances of the ground's x and y and of the camera's height.
[[nodiscard]] PoseCovariance covariance_over_ground(const Mat3& cam_from_map, double distance_m, const Mat3& attitude,
                                                    const Vec3& variances_m2);

/// By the latest fixes and the poses since. `frame` is of the fixes alone; `way_m` is the way of the camera since the
/// newest of them, in which the strip's own poses may drift. False where they do not say enough.
[[nodiscard]] bool prior_by_fixes(const navigation::StripFrame& frame, const PoseRecord& pose, double way_m,
                                  MapPrior& prior);

/// By the vehicle's measurements: `keyframe` has its own, places counted on the map's plane, and `frame` is of the
/// keyframes about it. Its place comes from its own position or the frame's, its attitude likewise, its height above
/// the ground at `ground_m` from its altimeter, the strip's unit or its elevation. False where one of these is not
/// known.
[[nodiscard]] bool prior_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe,
                                    double ground_m, MapPrior& prior);
/// Its x and y alone, for looking up the ground.
[[nodiscard]] bool place_by_vehicle(const navigation::StripFrame& frame, const navigation::MeasuredKeyframe& keyframe,
                                    Vec3& place_m, double& sigma_m);

}  // namespace ilp
