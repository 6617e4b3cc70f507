// The number of images that were not taken while the store could not be written.
#pragma once

#include <algorithm>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"

namespace ilp {

/// The least number of images that the mission wants after `from` and until `until` (a forecast may want more). 0 if
/// every frame is wanted, because the camera's counter then shows the number, and 0 if only telecommands cause images.
[[nodiscard]] inline std::int64_t images_missed(const MissionParameters& mission, TimeNs from, TimeNs until) {
  double interval_s = 0;
  if (mission.capture_mode == CaptureMode::regular) interval_s = mission.capture_interval_s;
  if (mission.capture_mode == CaptureMode::forecast) interval_s = mission.capture_max_interval_s;
  if (mission.safe_mode) interval_s = mission.capture_safe_interval_s;
  if (interval_s <= 0 || until < from) return 0;
  return (until - from) / std::max(ns_from_seconds(interval_s), minor_frame_ns);
}

}  // namespace ilp
