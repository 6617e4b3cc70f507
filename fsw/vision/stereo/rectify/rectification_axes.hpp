// What both ways of rectification start from: the baseline and the two optical axes.
#pragma once

#include <algorithm>

#include "fsw/base/geometry.hpp"
#include "fsw/base/status_values.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

[[nodiscard]] inline Status impossible(RectificationFault fault) {
  return {StatusCode::rectification_impossible, 0, static_cast<std::int64_t>(fault)};
}

/// The interval of the values included so far; empty before the first.
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

/// Unit vectors in the world; `baseline` in its units.
struct StereoAxes {
  Vec3 along = Vec3::UnitX();  ///< from the left camera's centre to the right one's
  Vec3 optical_left = Vec3::UnitZ(), optical_right = Vec3::UnitZ();
  double baseline = 0;
};

/// `rectification_impossible`: the baseline is below 1e-7 of `nearest`, the depth of the nearest ground, or the optical
/// axes are further apart than `max_axes_angle_rad`.
Status stereo_axes(const RigidTransform& left_from_world, const RigidTransform& right_from_world, double nearest,
                   double max_axes_angle_rad, StereoAxes& axes);

/// Rows are x along the baseline, y, and z along `ahead` less its part along the baseline.
[[nodiscard]] Mat3 frame_along_baseline(const StereoAxes& axes, const Vec3& ahead);

/// The pixel of the first camera at which the second one lies in front of it or behind it. False when there is none.
[[nodiscard]] bool epipole_of(const CameraModel& camera, const RigidTransform& second_from_first, Vec2& pixel);

}  // namespace ilp
