#include "fsw/places/place_recall.hpp"

#include <algorithm>
#include <cmath>
#include "fsw/places/place_blobs.hpp"
#include "fsw/shared/place_room.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int recalled_per_step = 8;

}  // namespace

/// A place that is newer than all depths is none: after it no keyframe would get one.
Status PlaceRecall::newest_place(std::int64_t& id) {
  std::int64_t newest_depth = 0;
  ILP_TRY(newest_id<DepthRecord>(wiring_.store, newest_depth));
  ILP_TRY(newest_id<PlaceRecord>(wiring_.store, id));
  while (id > newest_depth) {  // bound: the places in the store; each turn erases one
    ILP_TRY(erase_place(id));
    ILP_TRY(newest_id<PlaceRecord>(wiring_.store, id));
  }
  return {};
}

RememberedPlace PlaceRecall::entry_of(const PlaceRecord& place) {
  RememberedPlace entry;
  entry.keyframe_id = place.id;
  entry.strip_id = place.strip_id;
  for (int i = 0; i < 4; ++i) entry.q_cam_from_world[i] = static_cast<float>(place.q_cam_from_world[i]);
  for (int i = 0; i < 3; ++i) entry.centre[i] = static_cast<float>(place.centre[i]);
  entry.ground_distance = place.posed ? static_cast<float>(place.ground_distance) : 0.0F;
  entry.seen_again = place.links != 0;
  return entry;
}

/// A place of the vocabulary whose record is lost stays empty.
void PlaceRecall::fill_vocabulary(std::size_t through_slot) {
  for (std::size_t slot = 0; slot < through_slot && slot < PlaceTable::kept_for_ever; ++slot) {
    if (!workspace_.index.holds(slot)) static_cast<void>(workspace_.index.insert(slot, 0, {}));
  }
}

/// Where the memory refuses a place it may be the memory that is wrong: the place stays on record.
Status PlaceRecall::recall_place(const PlaceRecord& place, bool& sound) {
  sound = false;
  const auto slot = static_cast<std::size_t>(place.slot);
  const std::size_t count =
      std::min<std::size_t>(place.features.bytes / bytes_per_feature, workspace_.older.capacity());
  static_cast<void>(workspace_.older.resize(count));
  const Status read =
      read_blob<PlaceRecord>(wiring_.store, "features", place.id, 0, writable_octets(workspace_.older.data(), count));
  if (!read.ok()) return is_transient(read) ? read : Status{};
  sound = slot < limits::max_places;
  fill_vocabulary(slot);
  if (!workspace_.table.add(slot, entry_of(place))) return {};
  const Status inserted = workspace_.index.insert(slot, place.id, Features(workspace_.older.data(), count));
  if (!inserted.ok()) workspace_.table.remove(slot);
  return {};
}

Status PlaceRecall::recall() {
  for (int i = 0; i < recalled_per_step; ++i) {
    PlaceRecord place;
    const Status found = next(wiring_.store, work_.recalled_id, place);
    if (found.is(StatusCode::not_found)) {
      work_.phase = Phase::idle;
      return {};
    }
    if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
    const std::int64_t id = found.ok() ? place.id : found.a;
    const bool known = found.ok() && place.slot >= 0 && place.features.bytes != 0 && id <= cursor_.first;
    bool sound = false;
    if (known) ILP_TRY(recall_place(place, sound));
    // The newest one says how far the stage has come.
    if (!sound && id != cursor_.first) ILP_TRY(erase_place(id));
    work_.recalled_id = id;
  }
  return {};
}

Status PlaceRecall::erase_place(std::int64_t id) {
  work_.patience.begin_writing();
  Transaction transaction(wiring_.store);
  ILP_TRY(transaction.begin());
  const Status erased = erase<PlaceRecord>(wiring_.store, id);
  if (!erased.ok() && !erased.is(StatusCode::not_found)) return erased;
  ILP_TRY(transaction.commit());
  work_.patience.end_writing();
  return {};
}

/// Where fewer places have room than there are, since the parameters have changed.
Status PlaceRecall::forget_one(bool& forgotten) {
  forgotten = false;
  if (workspace_.table.count() <= places_with_room(wiring_.mission)) return {};
  const std::size_t slot = workspace_.table.least_needed();
  if (slot == limits::max_places) return {};
  ILP_TRY(erase_place(workspace_.table.at(slot).keyframe_id));
  workspace_.table.remove(slot);
  static_cast<void>(workspace_.index.remove(slot));
  forgotten = true;
  return {};
}

/// Features outside the image, or depths that are none, are not what was written.
Status PlaceRecall::load_features(const PlaceRecord& place, bool& sound) {
  sound = false;
  const std::size_t count =
      std::min<std::size_t>(place.features.bytes / bytes_per_feature, workspace_.older.capacity());
  if (count == 0) return {};
  static_cast<void>(workspace_.older.resize(count));
  Status read =
      read_blob<PlaceRecord>(wiring_.store, "features", place.id, 0, writable_octets(workspace_.older.data(), count));
  if (read.ok()) {
    read = read_blob<PlaceRecord>(wiring_.store, "features", place.id, count * sizeof(PlaceFeature),
                                  writable_octets(workspace_.older_depths.data(), count));
  }
  if (!read.ok()) return is_transient(read) ? read : Status{};
  const auto inside = [](float px, std::int32_t side) { return px >= 0 && px < static_cast<float>(side); };
  sound = true;
  for (std::size_t i = 0; i < count; ++i) {
    sound = sound && inside(workspace_.older[i].x, work_.camera.width) &&
            inside(workspace_.older[i].y, work_.camera.height) && workspace_.older_depths[i] >= 0 &&
            std::isfinite(workspace_.older_depths[i]);
  }
  return {};
}

}  // namespace ilp
