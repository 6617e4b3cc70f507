// How many images were not taken because the store could not be written.
#pragma once

#include <algorithm>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"

namespace ilp {

/// Images that the mission wants after `from` and until `until`, at least: a forecast may want them closer together. 0
/// where every frame is wanted, which the camera's counter tells, and where telecommands say when.
[[nodiscard]] inline std::int64_t images_missed(const MissionParameters& mission, TimeNs from, TimeNs until) {
  double interval_s = 0;
  if (mission.capture_mode == CaptureMode::regular) interval_s = mission.capture_interval_s;
  if (mission.capture_mode == CaptureMode::forecast) interval_s = mission.capture_max_interval_s;
  if (mission.safe_mode) interval_s = mission.capture_safe_interval_s;
  if (interval_s <= 0 || until < from) return 0;
  return (until - from) / std::max(ns_from_seconds(interval_s), minor_frame_ns);
}

}  // namespace ilp
