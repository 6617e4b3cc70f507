// The executive's level of reduced work, as components see it. A record holds it since its last change.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The level of a keyframe that is chosen now. It is written into the keyframe's record, so that everything derived
/// from it follows from records, whatever the load is later and however often the software restarts.
inline Status current_work_level(Reader<TimingRecord> store, std::uint8_t& level) {
  TimingRecord timing;
  const Status found = get(store, timing.id, timing);
  level = found.ok() ? timing.degraded : 0;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

/// Number of corners per keyframe: from level 1 on half of them, but enough for poses.
[[nodiscard]] inline double corners_at(std::uint8_t level, double corners) {
  constexpr double enough = 300;
  if (level == 0 || corners <= enough) return corners;
  return corners / 2 > enough ? corners / 2 : enough;
}

/// Scale of rectified images: half at level 2, which takes an eighth of the comparisons.
[[nodiscard]] inline double stereo_scale_at(std::uint8_t level) {
  return level < 2 ? 1 : 0.5;
}

}  // namespace ilp
