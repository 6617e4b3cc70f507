#include "fsw/places/place_recall.hpp"

#include <algorithm>
#include <cmath>
#include "fsw/places/place_blobs.hpp"
#include "fsw/shared/place_capacity.hpp"
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

Result<bool> PlaceRecall::read_features(const PlaceRecord& place) {
  const std::size_t count =
      std::min<std::size_t>(place.features.bytes / bytes_per_feature, workspace_.older.capacity());
  static_cast<void>(workspace_.older.resize(count));
  return found_by(
      read_blob<PlaceRecord>(wiring_.store, "features", place.id, 0, writable_octets(workspace_.older.data(), count)));
}

/// Where the memory refuses a place it may be the memory that is wrong: the place stays on record.
Result<bool> PlaceRecall::recall_place(const PlaceRecord& place) {
  const auto slot = static_cast<std::size_t>(place.slot);
  ILP_TAKE(const bool whole, read_features(place));
  if (!whole) return false;
  fill_vocabulary(slot);
  if (workspace_.table.add(slot, entry_of(place)) &&
      !workspace_.index.insert(slot, place.id, Features(workspace_.older.data(), workspace_.older.size())).ok())
    workspace_.table.remove(slot);
  return slot < limits::max_places;
}

Status PlaceRecall::recall() {
  for (int i = 0; i < recalled_per_step; ++i) {
    PlaceRecord place;
    ILP_TAKE(const Found found, find_next(wiring_.store, work_.recalled_id, place));
    if (found == Found::nothing) {
      work_.phase = Phase::idle;
      return {};
    }
    const bool known =
        found == Found::valid && place.slot >= 0 && place.features.bytes != 0 && place.id <= cursor_.first;
    ILP_TAKE(const bool valid, known ? recall_place(place) : Result<bool>(false));
    // The newest one says how far the stage has come.
    if (!valid && place.id != cursor_.first) ILP_TRY(erase_place(place.id));
    work_.recalled_id = place.id;
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
Result<bool> PlaceRecall::forget_one() {
  if (workspace_.table.count() <= places_with_capacity(wiring_.mission)) return false;
  const std::size_t slot = workspace_.table.least_needed();
  if (slot == limits::max_places) return false;
  ILP_TRY(erase_place(workspace_.table.at(slot).keyframe_id));
  workspace_.table.remove(slot);
  static_cast<void>(workspace_.index.remove(slot));
  return true;
}

/// Features outside the image, or depths that are none, are not what was written.
Result<bool> PlaceRecall::load_features(const PlaceRecord& place) {
  if (place.features.bytes < bytes_per_feature) return false;
  ILP_TAKE(const bool whole, read_features(place));
  if (!whole) return false;
  const std::size_t count = workspace_.older.size();
  ILP_TAKE(const bool deep,
           found_by(read_blob<PlaceRecord>(wiring_.store, "features", place.id, count * sizeof(PlaceFeature),
                                           writable_octets(workspace_.older_depths.data(), count))));
  if (!deep) return false;
  const auto inside = [](float px, std::int32_t side) { return px >= 0 && px < static_cast<float>(side); };
  for (std::size_t i = 0; i < count; ++i) {
    if (!inside(workspace_.older[i].x, work_.camera.width) || !inside(workspace_.older[i].y, work_.camera.height) ||
        !(workspace_.older_depths[i] >= 0) || !std::isfinite(workspace_.older_depths[i]))
      return false;
  }
  return true;
}

}  // namespace ilp
