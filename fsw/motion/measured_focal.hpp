// The focal length of an unknown camera by the plane of the ground and what the vehicle measured, keyframe by keyframe.
#pragma once

#include <type_traits>

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "fsw/shared/body_figure.hpp"
#include "fsw/vision/calibration/plane_focal.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {

/// Part of a checkpoint.
struct MeasuredFocal {
  PlaneViews planes;          ///< of the newest keyframes, oldest first
  PlaneFocal newest, before;  ///< with the newest keyframe, and without it
  BodyPlace origin;           ///< from where their places are counted
  bool placed = false;
  TimeNs latest_ns = 0;  ///< of the newest of them
};
static_assert(std::is_trivially_copyable_v<MeasuredFocal>);

/// Takes what was measured at a keyframe, and the plane that relates it to the one before; the oldest keyframe goes
/// when there is no room. Places count where the body is known.
void add_keyframe(const KeyframeRecord& keyframe, const NavigationRecord& navigation, const PlanePair& plane,
                  const CameraModel& nominal, Body body, MeasuredFocal& state);

/// Whether the focal length is certain enough to freeze the camera.
[[nodiscard]] bool suffices(const MeasuredFocal& state);
/// Whether it is better than a nominal one with this relative error, and any use.
[[nodiscard]] bool is_better_than(double nominal_relative_sigma, const MeasuredFocal& state);

/// The nominal camera with that focal length, not frozen.
[[nodiscard]] CameraRecord measured_camera(const CameraModel& nominal, const MeasuredFocal& state);

}  // namespace ilp
