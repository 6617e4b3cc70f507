// Reads the vehicle's measurements at a keyframe, for the stages that wait for them.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/shared/find.hpp"

namespace ilp {

/// Reads the measurements at a keyframe. Returns false if the navigator has not written them yet, and only transient
/// faults. `measured` is empty if the mission uses no navigation or the record is damaged.
inline Result<bool> measured_at(Reader<NavigationRecord> store, const MissionParameters& mission,
                                std::int64_t keyframe_id, NavigationRecord& measured) {
  measured = {};
  if (!mission.use_navigation) return true;
  const Status known = get(store, keyframe_id, measured);
  if (known.is(StatusCode::not_found)) return false;
  ILP_TAKE(const bool found, found_by(known));
  if (!found) measured = {};
  return true;
}

}  // namespace ilp
