// What is up by positions in three dimensions, where no attitude says it: the rotation of a similarity that takes the
// track of the images to the positions. The axis along which the track is longest, and the one across it, are laid onto
// their counterparts among the positions, the longer one exactly.
#pragma once

#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp::navigation {

struct PositionLevel {
  Mat3 level_from_strip = Mat3::Identity();
  /// Of what is up, rad; 0: the track is too straight, or too few positions have a height. A straight track says how
  /// steep it is, and leaves the roll about it open: `level_from_strip` then turns the strip by its slope only.
  double tilt_sigma_rad = 0;
  bool known = false;                         ///< false: nothing is turned
  Vec3 long_axis = Vec3::Zero();              ///< of the track in the strip
  double slope_rad = 0, slope_sigma_rad = 0;  ///< of that axis by the positions, upwards
};

/// Positions with a height only. Those farther than four deviations from the fit are left out of a second one.
[[nodiscard]] PositionLevel level_by_positions(const MeasuredKeyframes& keyframes);

/// By how many sigmas of the difference another level with this error, that of attitudes, contradicts a known one:
/// along a straight track by its slope, else by what is up.
[[nodiscard]] double sigmas_from_level(const PositionLevel& level, const Mat3& level_from_strip, double tilt_sigma_rad);

/// A receiver that has frozen repeats its position in every digit: whether most of the positions do so, three at least,
/// while the images move by half of the distance to the ground.
[[nodiscard]] bool positions_stand_still(const MeasuredKeyframes& keyframes);

}  // namespace ilp::navigation
