// How long records stay on board, so that the database of a flight of any length stays bounded.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"

namespace ilp {

/// The records of a keyframe (pose, structure, depth, richness, products, its frame) stay for `history_keyframes`, and
/// until the ground has confirmed them or ten times as many keyframes have passed, and as long as a product of it is
/// held or its points have not been sent. Frames that were not chosen and captures stay for `history_frames`, events
/// and commands for limits::max_events and limits::max_commands. A file's record is erased after its subject.
inline constexpr std::int64_t unconfirmed_factor = 10;

/// The tables whose old records may be erased.
using HistoryStore = StoreView<StoreAccess{.erases = stage_of(ComponentId::storage_manager).erases}>;

struct RecordHistory {
  std::int64_t asked_downlink_id = 0;
  std::int64_t asked_strip_id = 0;
  std::int64_t frame_id = 0;     ///< frames up to it are erased, unless a keyframe or the overlap checker needs them
  std::int64_t keyframe_id = 0;  ///< the newest keyframe among them
};

/// Advances by a bounded number of steps. Frames after `passed_frame_id` are still in use. Adds to `erased`.
Status erase_past(HistoryStore store, const MissionParameters& mission, std::int64_t passed_frame_id,
                  RecordHistory& history, std::int64_t& erased);

}  // namespace ilp
