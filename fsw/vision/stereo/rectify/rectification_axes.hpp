// Baseline and optical axes of a pair, which both methods of rectification start from.
#pragma once

#include <algorithm>

#include "fsw/base/geometry.hpp"
#include "fsw/base/status_values.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

[[nodiscard]] inline Status impossible(RectificationFault fault) {
  return {StatusCode::rectification_impossible, 0, static_cast<std::int64_t>(fault)};
}

/// The interval of the values included so far; empty before the first one.
struct Interval {
  double low = 1e300;
  double high = -1e300;

  void include(double v) {
    low = std::min(low, v);
    high = std::max(high, v);
  }
  [[nodiscard]] bool empty() const { return high < low; }
  [[nodiscard]] double length() const { return high - low; }
};

/// Axes as unit vectors in the world; `baseline` in world units.
struct StereoAxes {
  Vec3 along = Vec3::UnitX();  ///< from the left camera's centre to the right one's
  Vec3 optical_left = Vec3::UnitZ(), optical_right = Vec3::UnitZ();
  double baseline = 0;
};

/// Computes the axes of a pair. Returns `rectification_impossible` if the baseline is below 1e-7 times `nearest`, the
/// depth of the nearest ground, or if the angle between the optical axes exceeds `max_axes_angle_rad`.
Status stereo_axes(const RigidTransform& left_from_world, const RigidTransform& right_from_world, double nearest,
                   double max_axes_angle_rad, StereoAxes& axes);

/// Returns the rotation whose rows are the axes x, y, z: x along the baseline, z along the part of `ahead` that is
/// perpendicular to the baseline.
[[nodiscard]] Mat3 frame_along_baseline(const StereoAxes& axes, const Vec3& ahead);

/// Computes the epipole: the pixel of the first camera at which the second camera lies, in front of the first or behind
/// it. Returns false if there is none.
[[nodiscard]] bool epipole_of(const CameraModel& camera, const RigidTransform& second_from_first, Vec2& pixel);

}  // namespace ilp
