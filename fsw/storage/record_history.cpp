#include "fsw/storage/record_history.hpp"

#include "fsw/shared/find.hpp"
#include "fsw/shared/valid_store.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int rows_per_step = 8;

/// A missing row counts as erased.
template <typename Record>
Status erase(HistoryStore store, std::int64_t id, std::int64_t& erased) {
  const Status status = ilp::erase<Record>(store, id);
  if (status.is(StatusCode::not_found)) return {};
  ILP_TRY(status);
  ++erased;
  return {};
}

/// The newest id, from which a history of `kept` is counted back. Ids of a new store epoch begin far after those of the
/// previous store epoch (Store::id_base). Records of the previous store epoch are not older because of that: they stay
/// until this store epoch has a history of its own.
template <typename Record>
Status newest_that_counts(HistoryStore store, std::int64_t kept, std::int64_t& newest) {
  ILP_TRY(newest_id<Record>(store, newest));
  const bool young = newest - kept <= store.id_base(record_type<Record>);
  if (young && newest > kept) newest = kept;
  return {};
}

template <typename Record>
Status erase_but_last(HistoryStore store, std::int64_t id, std::int64_t& erased) {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<Record>(store, newest));
  return id == newest ? Status{} : erase<Record>(store, id, erased);
}

/// Erases rows older than the newest `kept`.
template <typename Record, typename May>
Status erase_oldest(HistoryStore store, std::int64_t kept, May may, std::int64_t& erased) {
  std::int64_t newest = 0;
  ILP_TRY(newest_that_counts<Record>(store, kept, newest));
  for (int i = 0; i < rows_per_step; ++i) {
    Record oldest;
    ILP_TAKE(const bool found, find_next_valid(store, 0, oldest));
    if (!found || oldest.id > newest - kept || !may(oldest)) return {};
    ILP_TRY(erase<Record>(store, oldest.id, erased));
  }
  return {};
}

Status erase_frame(HistoryStore store, const FrameRecord& frame, std::int64_t& erased) {
  if (frame.capture_id != 0) ILP_TRY(erase_but_last<CaptureRecord>(store, frame.capture_id, erased));
  ILP_TRY(erase<OverlapRecord>(store, frame.id, erased));
  ILP_TRY(erase<FramePlaneRecord>(store, frame.id, erased));
  return erase<FrameRecord>(store, frame.id, erased);
}

/// Erases frames that were not chosen.
Status erase_frames(HistoryStore store, std::int64_t kept, std::int64_t passed_id, RecordHistory& history,
                    std::int64_t& erased) {
  std::int64_t newest = 0;
  ILP_TRY(newest_that_counts<FrameRecord>(store, kept, newest));
  const std::int64_t oldest_kept = newest - kept;
  for (int i = 0; i < rows_per_step; ++i) {
    FrameRecord frame;
    ILP_TAKE(const bool any, find_next_valid(store, history.frame_id, frame));
    if (!any || frame.id > oldest_kept || frame.id > passed_id) return {};
    KeyframeRecord keyframe;
    ILP_TAKE(const bool found, find_next_valid(store, history.keyframe_id, keyframe));
    if (found && keyframe.frame_id < frame.id) {
      history.keyframe_id = keyframe.id;
      continue;
    }
    history.frame_id = frame.id;
    const bool chosen = found && keyframe.frame_id == frame.id;
    if (!chosen && frame.image.bytes == 0) ILP_TRY(erase_frame(store, frame, erased));
  }
  return {};
}

/// Erases frames before the oldest keyframe left, whatever held them back.
Status erase_frames_before(HistoryStore store, const KeyframeRecord& oldest, std::int64_t passed_id,
                           std::int64_t& erased) {
  for (int i = 0; i < rows_per_step; ++i) {
    FrameRecord frame;
    ILP_TAKE(const bool found, find_next_valid(store, 0, frame));
    if (!found || frame.id >= oldest.frame_id || frame.id > passed_id || frame.image.bytes != 0) return {};
    ILP_TRY(erase_frame(store, frame, erased));
  }
  return {};
}

/// Examines one more strip, in turns: it is erased when it has no keyframe left.
Status erase_strip(HistoryStore store, RecordHistory& history, std::int64_t& erased) {
  StripRecord strip;
  ILP_TAKE(const bool found, find_next_valid(store, history.asked_strip_id, strip));
  history.asked_strip_id = found ? strip.id : 0;
  if (!found) return {};
  KeyframeRecord keyframe;
  ILP_TAKE(const bool any, find_next_valid(store, strip.first_keyframe_id - 1, keyframe));
  if (strip.end == StripEnd::open || !any || keyframe.id <= strip.last_keyframe_id) return {};
  ILP_TRY(erase_but_last<CalibrationCheckRecord>(store, strip.id, erased));
  ILP_TRY(erase<StripFrameRecord>(store, strip.id, erased));
  ILP_TRY(erase<TieRecord>(store, strip.id, erased));
  return erase<StripRecord>(store, strip.id, erased);
}

/// Whether products, points or a mask exist that the ground may not hold yet.
Result<bool> holds_bytes(HistoryStore store, std::int64_t keyframe_id) {
  StructureRecord structure;
  ILP_TAKE(const bool known, find(store, keyframe_id, structure));
  MaskRecord mask;
  ILP_TAKE(const bool masked, find(store, keyframe_id, mask));
  bool held = (known && structure.points.bytes != 0) || (masked && mask.code.bytes != 0);
  for (std::int64_t kind = 0; kind < static_cast<std::int64_t>(ProductKind::count); ++kind) {
    ProductRecord product;
    ILP_TAKE(const bool found, find(store, product_id(keyframe_id, static_cast<ProductKind>(kind)), product));
    held = held || (found && product.data.bytes != 0);
  }
  return held;
}

Status erase_keyframe(HistoryStore store, std::int64_t id, std::int64_t& erased) {
  for (std::int64_t kind = 0; kind < static_cast<std::int64_t>(ProductKind::count); ++kind) {
    ILP_TRY(erase<ProductRecord>(store, product_id(id, static_cast<ProductKind>(kind)), erased));
  }
  ILP_TRY(erase<RichnessRecord>(store, id, erased));
  ILP_TRY(erase_but_last<NavigationRecord>(store, id, erased));
  for (std::int64_t number = 0; number < limits::max_links_per_keyframe; ++number) {
    ILP_TRY(erase<LinkRecord>(store, link_id(id, number), erased));
  }
  ILP_TRY(erase<MaskRecord>(store, id, erased));
  ILP_TRY(erase<DepthRecord>(store, id, erased));
  ILP_TRY(erase<StructureRecord>(store, id, erased));
  ILP_TRY(erase_but_last<CalibrationRecord>(store, id, erased));
  ILP_TRY(erase<PoseRecord>(store, id, erased));
  ILP_TRY(erase<ShutterRecord>(store, id, erased));
  ILP_TRY(erase_but_last<FixRecord>(store, id, erased));
  KeyframeRecord keyframe;
  ILP_TAKE(const bool found, find(store, id, keyframe));
  if (found) {
    FrameRecord frame;
    ILP_TAKE(const bool framed, find(store, keyframe.frame_id, frame));
    if (framed) ILP_TRY(erase_frame(store, frame, erased));
  }
  return erase<KeyframeRecord>(store, id, erased);
}

/// A file older than the history: its subject is erased, if nothing of it is still needed, and then its record.
Status retire(HistoryStore store, const DownlinkRecord& sent, bool waited_long, std::int64_t& erased) {
  const bool confirmed = sent.acknowledged_ns != 0 || waited_long;
  if (sent.kind == DownlinkKind::product) {
    ProductRecord product;
    ILP_TAKE(const bool found, find(store, sent.subject_id, product));
    if (found && product.data.bytes != 0) return {};
    return erase<DownlinkRecord>(store, sent.id, erased);
  }
  if (!confirmed) return {};
  if (sent.kind == DownlinkKind::records && sent.subject_id > 0) {
    ILP_TAKE(const bool held, holds_bytes(store, sent.subject_id));
    if (held) return {};
    ILP_TRY(erase_keyframe(store, sent.subject_id, erased));
  }
  return erase<DownlinkRecord>(store, sent.id, erased);
}

Status erase_keyframes(HistoryStore store, std::int64_t kept, RecordHistory& history, std::int64_t& erased) {
  std::int64_t newest = 0;
  std::int64_t newest_file = 0;
  ILP_TRY(newest_that_counts<KeyframeRecord>(store, kept, newest));
  ILP_TRY(newest_id<DownlinkRecord>(store, newest_file));
  const std::int64_t before = erased;
  bool from_the_first = history.asked_downlink_id == 0;
  for (int i = 0; i < rows_per_step && erased == before; ++i) {
    DownlinkRecord sent;
    ILP_TAKE(const bool found, find_next_valid(store, history.asked_downlink_id, sent));
    // In turns, so that a waiting one does not delay those after it.
    if (!found || sent.records_through > newest - kept || sent.id == newest_file) {
      history.asked_downlink_id = 0;
      if (from_the_first) return {};
      from_the_first = true;
      continue;
    }
    history.asked_downlink_id = sent.id;
    ILP_TRY(retire(store, sent, sent.records_through <= newest - unconfirmed_factor * kept, erased));
  }
  return {};
}

}  // namespace

Status erase_past(HistoryStore store, const MissionParameters& mission, std::int64_t passed_frame_id,
                  RecordHistory& history, std::int64_t& erased) {
  const std::int64_t frames = mission.history_frames;
  const std::int64_t keyframes = mission.history_keyframes;
  ILP_TRY(erase_keyframes(store, keyframes, history, erased));
  ILP_TRY(erase_frames(store, frames, passed_frame_id, history, erased));
  KeyframeRecord oldest;
  ILP_TAKE(const bool found, find_next_valid(store, 0, oldest));
  if (found && oldest.id > 1) ILP_TRY(erase_frames_before(store, oldest, passed_frame_id, erased));
  ILP_TRY(erase_strip(store, history, erased));
  const auto any = [](const auto&) { return true; };
  const auto over = [](const CaptureRecord& capture) { return capture.state != CaptureState::pending; };
  ILP_TRY(erase_oldest<CaptureRecord>(store, frames, over, erased));
  ILP_TRY(erase_oldest<CommandRecord>(store, limits::max_commands, any, erased));
  return erase_oldest<EventRecord>(store, limits::max_events, any, erased);
}

}  // namespace ilp
