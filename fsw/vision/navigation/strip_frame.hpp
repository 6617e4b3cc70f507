// Estimates how the world frame of a strip lies in the level frame. The images determine it up to a similarity, and the
// vehicle's measurements at the keyframes determine the similarity. Measurements that contradict the motion of the
// images are refused.
//
// Attitudes give the vertical and north. Heights above ground, distances between positions, and velocities give the
// length of the strip unit. Positions give the origin. Fixes on a map give all four. Each quantity is a robust mean
// over the keyframes (robust_mean.hpp).
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/navigation_sample.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/navigation/robust_mean.hpp"

namespace ilp::navigation {

/// A keyframe's fix on a map. Unlike a sensor's reading it comes from many patches that agree, so a single fix is
/// accepted.
struct FixMeasurement {
  double q_cam_from_level[4] = {1, 0, 0, 0};
  double tilt_sigma_rad = 0, heading_sigma_rad = 0;
  double ground_m[3] = {0, 0, 0};  ///< where the optical axis meets the ground: east, north, up from the reference
  double ground_sigma_m[3] = {0, 0, 0};         ///< east, north, up; 0: there is no fix
  double distance_m = 0, distance_sigma_m = 0;  ///< distance of that point from the camera
  double depth = 0, depth_sigma = 0;            ///< the same from the images, strip units; 0: unknown
  double map_sigma_m = 0;                       ///< error of the map's own position, common to all fixes
  double shared = 0;                            ///< share of the variances that is common to fixes on the same ground
};

/// A keyframe with a final pose, and the vehicle's measurements at its exposure. A measurement with sigma 0 is missing.
struct MeasuredKeyframe {
  std::int64_t keyframe_id = 0;
  TimeNs time_ns = 0;
  double centre[3] = {0, 0, 0};  ///< strip units
  double q_cam_from_strip[4] = {1, 0, 0, 0};
  double ground_distance = 0;  ///< from the camera down to the ground, strip units; 0: unknown
  double ground_distance_sigma = 0;
  double height_m = 0, height_sigma_m = 0;  ///< above the ground
  double q_cam_from_level[4] = {1, 0, 0, 0};
  double tilt_sigma_rad = 0, heading_sigma_rad = 0;
  double place_m[3] = {0, 0, 0};  ///< east, north, up from the reference position
  double horizontal_sigma_m = 0, vertical_sigma_m = 0;
  double velocity_m_s[3] = {0, 0, 0};  ///< east, north, up
  double velocity_sigma_m_s = 0;
  FixMeasurement fix;
};
/// In order of time.
using MeasuredKeyframes = FixedVector<MeasuredKeyframe, max_values>;
/// Appends a keyframe. If the list is full, every second keyframe is dropped first.
void add_thinned(const MeasuredKeyframe& keyframe, MeasuredKeyframes& keyframes);

/// Number of measurements of one kind that were used, and that were refused as contradictory.
struct Use {
  std::uint32_t used = 0, refused = 0;
};

struct StripFrame {
  StripFrameVerdict verdict = StripFrameVerdict::nothing_measured;
  double metres_per_unit = 1;
  double scale_sigma = 0;  ///< relative; 0: metres_per_unit is unknown
  Mat3 level_from_strip = Mat3::Identity();
  double tilt_sigma_rad = 0;      ///< 0: the vertical is unknown
  double heading_sigma_rad = 0;   ///< 0: north is unknown
  Vec3 origin_m = Vec3::Zero();   ///< origin of the strip frame, from the reference position
  double horizontal_sigma_m = 0;  ///< 0: the origin is unknown
  double vertical_sigma_m = 0;
  Use heights, attitudes, positions, velocities, fixes;
  // From the fixes alone, for points near them: the middle of the fixes' ground points in the strip frame and in the
  // level frame. The similarity rotates and scales the strip about this point.
  Vec3 fixed_ground = Vec3::Zero();  ///< strip units
  Vec3 fixed_place_m = Vec3::Zero();
  double fixed_sigma_m[3] = {0, 0, 0};  ///< east, north, up, without map_sigma_m; 0: there is no fix
};

/// Heights, attitudes, positions and velocities need three keyframes each, fixes need one.
[[nodiscard]] StripFrame estimate_strip_frame(const MeasuredKeyframes& keyframes);

/// Position of a point of the strip from the fixes alone. Its errors include those of heading, tilt and scale, which
/// grow with the distance from the middle of the fixes.
struct FixedPlace {
  Vec3 place_m = Vec3::Zero();
  double sigma_m[3] = {0, 0, 0};
};
/// `point` is in the strip frame; `frame` must have fixes.
[[nodiscard]] FixedPlace place_by_fixes(const StripFrame& frame, const Vec3& point);

/// Standard deviations of tilt and heading from the covariance of an attitude (rotation vector in the camera's axes,
/// rad^2).
void level_sigmas(const Mat3& covariance, const Mat3& cam_from_level, double& tilt_sigma_rad,
                  double& heading_sigma_rad);

}  // namespace ilp::navigation
