// What the memory of places reads of its records, after a start or to compare, and what it forgets.
#include <algorithm>
#include <cmath>

#include "fsw/places/place_blobs.hpp"
#include "fsw/places/place_memory.hpp"
#include "fsw/shared/place_room.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int recalled_per_step = 8;

}  // namespace

Status PlaceMemory::restore() {
  phase_ = Phase::recall;
  keeps_ = false;
  recalled_id_ = 0;
  table_.clear();
  index_.clear();
  const Status status = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(newest_place(newest));
  // Other components have used the records: they are not made again.
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

/// A place that is newer than all depths is none: after it no keyframe would get one.
Status PlaceMemory::newest_place(std::int64_t& id) {
  std::int64_t newest_depth = 0;
  ILP_TRY(newest_id<DepthRecord>(store_, newest_depth));
  ILP_TRY(newest_id<PlaceRecord>(store_, id));
  while (id > newest_depth) {  // bound: the places in the store; each turn erases one
    ILP_TRY(erase_place(id));
    ILP_TRY(newest_id<PlaceRecord>(store_, id));
  }
  return {};
}

RememberedPlace PlaceMemory::entry_of(const PlaceRecord& place) {
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
void PlaceMemory::fill_vocabulary(std::size_t through_slot) {
  for (std::size_t slot = 0; slot < through_slot && slot < PlaceTable::kept_for_ever; ++slot) {
    if (!index_.holds(slot)) static_cast<void>(index_.insert(slot, 0, {}));
  }
}

/// Where the memory refuses a place it may be the memory that is wrong: the place stays on record.
Status PlaceMemory::recall_place(const PlaceRecord& place, bool& sound) {
  sound = false;
  const auto slot = static_cast<std::size_t>(place.slot);
  const std::size_t count = std::min<std::size_t>(place.features.bytes / bytes_per_feature, older_.capacity());
  static_cast<void>(older_.resize(count));
  const Status read = read_blob<PlaceRecord>(store_, "features", place.id, 0, writable_octets(older_.data(), count));
  if (!read.ok()) return is_transient(read) ? read : Status{};
  sound = slot < limits::max_places;
  fill_vocabulary(slot);
  if (!table_.add(slot, entry_of(place))) return {};
  const Status inserted = index_.insert(slot, place.id, Features(older_.data(), count));
  if (!inserted.ok()) table_.remove(slot);
  return {};
}

Status PlaceMemory::recall() {
  for (int i = 0; i < recalled_per_step; ++i) {
    PlaceRecord place;
    const Status found = next(store_, recalled_id_, place);
    if (found.is(StatusCode::not_found)) {
      phase_ = Phase::idle;
      return {};
    }
    if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
    const std::int64_t id = found.ok() ? place.id : found.a;
    const bool known = found.ok() && place.slot >= 0 && place.features.bytes != 0 && id <= cursor_.first;
    bool sound = false;
    if (known) ILP_TRY(recall_place(place, sound));
    // The newest one says how far the stage has come.
    if (!sound && id != cursor_.first) ILP_TRY(erase_place(id));
    recalled_id_ = id;
  }
  return {};
}

Status PlaceMemory::erase_place(std::int64_t id) {
  patience_.begin_writing();
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  const Status erased = erase<PlaceRecord>(store_, id);
  if (!erased.ok() && !erased.is(StatusCode::not_found)) return erased;
  ILP_TRY(transaction.commit());
  patience_.end_writing();
  return {};
}

/// Where fewer places have room than there are, since the parameters have changed.
Status PlaceMemory::forget_one(bool& forgotten) {
  forgotten = false;
  if (table_.count() <= places_with_room(mission_)) return {};
  const std::size_t slot = table_.least_needed();
  if (slot == limits::max_places) return {};
  ILP_TRY(erase_place(table_.at(slot).keyframe_id));
  table_.remove(slot);
  static_cast<void>(index_.remove(slot));
  forgotten = true;
  return {};
}

/// Features outside the image, or depths that are none, are not what was written.
Status PlaceMemory::load_features(const PlaceRecord& place, bool& sound) {
  sound = false;
  const std::size_t count = std::min<std::size_t>(place.features.bytes / bytes_per_feature, older_.capacity());
  if (count == 0) return {};
  static_cast<void>(older_.resize(count));
  Status read = read_blob<PlaceRecord>(store_, "features", place.id, 0, writable_octets(older_.data(), count));
  if (read.ok()) {
    read = read_blob<PlaceRecord>(store_, "features", place.id, count * sizeof(PlaceFeature),
                                  writable_octets(older_depths_.data(), count));
  }
  if (!read.ok()) return is_transient(read) ? read : Status{};
  const auto inside = [](float px, std::int32_t side) { return px >= 0 && px < static_cast<float>(side); };
  sound = true;
  for (std::size_t i = 0; i < count; ++i) {
    sound = sound && inside(older_[i].x, camera_.width) && inside(older_[i].y, camera_.height) &&
            older_depths_[i] >= 0 && std::isfinite(older_depths_[i]);
  }
  return {};
}

}  // namespace ilp
