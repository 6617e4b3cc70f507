// The executive's level of reduced work and its effect on components. The timing record holds the present level.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Reads the present level; 0 (full work) if there is no record. A keyframe's record gets the level at which the
/// keyframe was chosen, so that all results follow from records, independently of later load and restarts.
inline Status current_work_level(Reader<TimingRecord> store, std::uint8_t& level) {
  TimingRecord timing;
  const Status found = get(store, timing.id, timing);
  level = found.ok() ? timing.degraded : 0;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

/// Number of corners per keyframe at a level: from level 1 on half of `corners`, but at least 300, which suffices for
/// poses.
[[nodiscard]] inline double corners_at(std::uint8_t level, double corners) {
  constexpr double enough = 300;
  if (level == 0 || corners <= enough) return corners;
  return corners / 2 > enough ? corners / 2 : enough;
}

/// Scale factor of rectified images: 1/2 from level 2 on, which takes an eighth of the comparisons.
[[nodiscard]] inline double stereo_scale_at(std::uint8_t level) {
  return level < 2 ? 1 : 0.5;
}

}  // namespace ilp
