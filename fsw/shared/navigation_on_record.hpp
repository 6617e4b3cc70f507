// What the vehicle measured at a keyframe, for the stages that wait for it.
#pragma once

#include "cfg/mission.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// `measured` is empty if the mission uses no navigation, or if the record is damaged. `waits`: the navigator has not
/// written the keyframe's record yet. Returns only faults that may pass.
inline Status measured_at(Reader<NavigationRecord> store, const MissionParameters& mission, std::int64_t keyframe_id,
                          NavigationRecord& measured, bool& waits) {
  waits = false;
  measured = {};
  if (!mission.use_navigation) return {};
  const Status known = get(store, keyframe_id, measured);
  waits = known.is(StatusCode::not_found);
  if (!known.ok()) measured = {};
  return is_transient(known) && !waits ? known : Status{};
}

}  // namespace ilp
