// Estimates the vertical of a strip from positions in three dimensions, if no attitude gives it: the rotation of the
// similarity from the images' track to the positions. The longest axis of the track, and the widest axis across it, are
// aligned to the corresponding axes of the positions; the alignment of the longest axis is exact.
#pragma once

#include "fsw/vision/navigation/strip_frame.hpp"

namespace ilp::navigation {

struct PositionLevel {
  Mat3 level_from_strip = Mat3::Identity();
  /// Standard deviation of the vertical, rad. 0: the track is too straight, or too few positions have a height. A
  /// straight track determines its slope, but not the roll about it: `level_from_strip` then corrects the slope only.
  double tilt_sigma_rad = 0;
  bool known = false;                         ///< false: `level_from_strip` is the identity
  Vec3 long_axis = Vec3::Zero();              ///< direction of the track in the strip frame
  double slope_rad = 0, slope_sigma_rad = 0;  ///< slope of that axis according to the positions, upwards > 0
};

/// Uses only positions with a height. Positions farther than four standard deviations from a first fit are excluded
/// from the second.
[[nodiscard]] PositionLevel level_by_positions(const MeasuredKeyframes& keyframes);

/// Contradiction between a known level and one from attitudes with the error `tilt_sigma_rad`: their difference divided
/// by its standard deviation. Compares the slopes of the track and, if `level` determines the vertical, also the
/// verticals; the larger value counts.
[[nodiscard]] double sigmas_from_level(const PositionLevel& level, const Mat3& level_from_strip, double tilt_sigma_rad);

/// Detects a receiver that repeats its last position in every digit. True if more than half of the positions, and at
/// least three, repeat the previous one while the images move by at least half of the distance to the ground.
[[nodiscard]] bool positions_stand_still(const MeasuredKeyframes& keyframes);

}  // namespace ilp::navigation
