// Erases old records, so that the size of the database is bounded for flights of any length.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"

namespace ilp {

/// The records of a keyframe (pose, structure, depth, richness, products, its frame) stay until all of these are true:
/// it is older than the newest `history_keyframes`; the ground has confirmed the records, or it is older than the
/// newest unconfirmed_factor * `history_keyframes`; no product of it is held; and its points have been sent. Frames
/// that are no keyframes, and captures, stay for `history_frames` frames. The newest limits::max_events events and
/// limits::max_commands commands stay. The record of a sent file is erased after the record of its subject.
inline constexpr std::int64_t unconfirmed_factor = 10;

/// The tables whose old records may be erased.
using HistoryStore = StoreView<StoreAccess{.erases = stage_of(ComponentId::storage_manager).erases}>;

struct RecordHistory {
  std::int64_t asked_downlink_id = 0;
  std::int64_t asked_strip_id = 0;
  std::int64_t frame_id = 0;  ///< frames up to this one are erased, unless a keyframe or the overlap checker needs them
  std::int64_t keyframe_id = 0;  ///< the newest keyframe among these frames
};

/// Erases a bounded number of records. Frames after `passed_frame_id` are still in use. Adds the number of erased
/// records to `erased`.
Status erase_past(HistoryStore store, const MissionParameters& mission, std::int64_t passed_frame_id,
                  RecordHistory& history, std::int64_t& erased);

}  // namespace ilp
