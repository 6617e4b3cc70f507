// Where the world of a strip lies: the images know it up to a similarity, and the vehicle's measurements at its
// keyframes determine that similarity. The images' own motion decides which measurements contradict.
//
// Attitudes give what is up, and north; heights above ground, the distance between positions, and velocities give the
// length of the strip unit; positions give the place. Fixes on a map give all four. Each quantity is a robust mean over
// the keyframes (robust_mean.hpp).
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/navigation_sample.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/navigation/robust_mean.hpp"

namespace ilp::navigation {

/// What a keyframe's fix on a map says. Unlike a sensor's reading it stands on many patches of the image that agree, so
/// that one counts.
struct FixMeasurement {
  double q_cam_from_level[4] = {1, 0, 0, 0};
  double tilt_sigma_rad = 0, heading_sigma_rad = 0;
  double ground_m[3] = {0, 0, 0};        ///< where the optical axis meets the ground, from the place of reference
  double ground_sigma_m[3] = {0, 0, 0};  ///< east, north, up; 0: there is no fix
  double distance_m = 0, distance_sigma_m = 0;  ///< of that point from the camera
  double depth = 0, depth_sigma = 0;            ///< the same by the images, strip units; 0: not known
  double map_sigma_m = 0;                       ///< of the place of the map as a whole, common to all fixes
  double shared = 0;  ///< share of the variances that fixes over the same ground have in common
};

/// A keyframe with a final pose, and what the vehicle measured at its exposure.
struct MeasuredKeyframe {
  std::int64_t keyframe_id = 0;
  TimeNs time_ns = 0;
  double centre[3] = {0, 0, 0};  ///< strip units
  double q_cam_from_strip[4] = {1, 0, 0, 0};
  double ground_distance = 0;  ///< from the camera down to the ground, strip units; 0: not known
  double ground_distance_sigma = 0;
  double height_m = 0, height_sigma_m = 0;
  double q_cam_from_level[4] = {1, 0, 0, 0};
  double tilt_sigma_rad = 0, heading_sigma_rad = 0;
  double place_m[3] = {0, 0, 0};  ///< east, north, up from the place of reference
  double horizontal_sigma_m = 0, vertical_sigma_m = 0;
  double velocity_m_s[3] = {0, 0, 0};
  double velocity_sigma_m_s = 0;
  FixMeasurement fix;
};
/// In order of time. A list that is full is thinned out evenly.
using MeasuredKeyframes = FixedVector<MeasuredKeyframe, max_values>;
void add_thinned(const MeasuredKeyframe& keyframe, MeasuredKeyframes& keyframes);

/// Measurements of one kind: those that took part, and those that contradicted the others.
struct Use {
  std::uint32_t used = 0, refused = 0;
};

struct StripFrame {
  StripFrameVerdict verdict = StripFrameVerdict::nothing_measured;
  double metres_per_unit = 1;
  double scale_sigma = 0;  ///< relative; 0: the length of the strip unit is not known
  Mat3 level_from_strip = Mat3::Identity();
  double tilt_sigma_rad = 0;      ///< 0: what is up is not known
  double heading_sigma_rad = 0;   ///< 0: what is north is not known
  Vec3 origin_m = Vec3::Zero();   ///< of the strip's world, from the place of reference
  double horizontal_sigma_m = 0;  ///< 0: the place is not known
  double vertical_sigma_m = 0;
  Use heights, attitudes, positions, velocities, fixes;
  // By the fixes alone, for what stands near them: the middle of their ground points in the strip and in the level
  // frame. The similarity turns and stretches the strip about it.
  Vec3 fixed_ground = Vec3::Zero();  ///< strip units
  Vec3 fixed_place_m = Vec3::Zero();
  double fixed_sigma_m[3] = {0, 0, 0};  ///< east, north, up, without the map's common error; 0: there is no fix
};

/// Heights, attitudes, positions and velocities need three keyframes, fixes one.
[[nodiscard]] StripFrame estimate_strip_frame(const MeasuredKeyframes& keyframes);

/// Where a point of the strip lies by the fixes alone, with the errors of heading, tilt and length over the way from
/// their middle. Call it for a frame with fixes.
struct FixedPlace {
  Vec3 place_m = Vec3::Zero();
  double sigma_m[3] = {0, 0, 0};
};
[[nodiscard]] FixedPlace place_by_fixes(const StripFrame& frame, const Vec3& point);

/// The tilt and heading sigma of an attitude whose covariance is that of a rotation vector in the camera's axes.
void level_sigmas(const Mat3& covariance, const Mat3& cam_from_level, double& tilt_sigma_rad,
                  double& heading_sigma_rad);

}  // namespace ilp::navigation
