#include "fsw/places/place_memory.hpp"

#include <algorithm>

#include "fsw/places/place_blobs.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/place_capacity.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// The reading of the places after a start, as an input for work_.patience.
constexpr std::int64_t recall_subject = -1;

static_assert(sizeof(PlaceRecord) + limits::max_place_features * bytes_per_feature +
                  limits::max_place_patches * sizeof(PlacePatch) + max_seen_cells <=
              most_place_bytes);

}  // namespace

constexpr CheckpointForm PlaceMemory::checkpoint = checkpoint_form<State>(component_id);

PlaceMemory::PlaceMemory(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, mission, scratch} {}

Status PlaceMemory::restore() {
  work_.phase = Phase::recall;
  work_.keeps = false;
  work_.recalled_id = 0;
  workspace_.table.clear();
  workspace_.index.clear();
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(part<PlaceRecall>().newest_place(newest));
  // Other components have used the records: they are not made again.
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

LastingMemory PlaceMemory::lasting() const {
  const LastingMemory memory =
      LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  if (!work_.keeps) return memory;
  const auto& scratch = wiring_.scratch.as<PlaceScratch>();
  const LastingMemory corners = memory.keeping(scratch.harris.progress);
  return work_.phase == Phase::features ? corners.keeping(scratch.features.progress)
                                        : corners.keeping(scratch.patches.corners_found);
}

Result<bool> PlaceMemory::pick() {
  ILP_TAKE(const bool forgotten, part<PlaceRecall>().forget_one());
  if (forgotten) return true;
  ILP_TAKE(const Found found, find_next(wiring_.store, cursor_.first, work_.depth));
  if (found == Found::nothing) return false;
  work_.mask = {};
  const Status masked = get(wiring_.store, work_.depth.id, work_.mask);
  if (!masked.ok() && !is_gone(masked) && !work_.patience.abandoned(work_.depth.id)) return masked;
  // Nobody waits for a mask that is gone. One that was abandoned is superseded by an empty one.
  if (!is_gone(masked)) work_.mask.id = work_.depth.id;
  static_cast<void>(workspace_.features.resize(0));
  workspace_.patches.clear();
  work_.links.clear();
  work_.candidates.clear();
  work_.compared = 0;
  work_.drift = {};
  workspace_.known.fill(0);
  work_.known_before = 0;
  work_.marked = 0;
  work_.mask_loaded = work_.mask_changed = false;
  work_.keyframe = {};
  work_.pose = {};
  work_.ground_distance = 0;
  const bool bare =
      found == Found::damaged || !wiring_.mission.place_memory || work_.patience.abandoned(work_.depth.id);
  work_.phase = bare ? Phase::record : Phase::load;
  return true;
}

Status PlaceMemory::load_cells() {
  ILP_TRY(clear_seen_cells(work_.camera.width, work_.camera.height, workspace_.seen));
  const std::size_t cells = cell_count(workspace_.seen);
  workspace_.depths.fill(0);
  if (work_.depth.cells.bytes != cells * (1 + sizeof(float))) return {};
  ILP_TRY(read_blob<DepthRecord>(wiring_.store, "cells", work_.depth.id, 0,
                                 writable_octets(workspace_.seen.quality.data(), cells)));
  return read_blob<DepthRecord>(wiring_.store, "cells", work_.depth.id, cells,
                                writable_octets(workspace_.depths.data(), cells));
}

void PlaceMemory::give_depths() {
  std::size_t deep = 0;
  for (std::size_t i = 0; i < workspace_.features.size(); ++i)
    workspace_.feature_depths[i] =
        depth_at(workspace_.depths, workspace_.seen, workspace_.features[i].x, workspace_.features[i].y);
  for (PlacePatch& patch : workspace_.patches)
    patch.inverse_depth = depth_at(workspace_.depths, workspace_.seen, patch.x, patch.y);
  double sum = 0;
  for (std::size_t i = 0; i < cell_count(workspace_.seen); ++i) {
    if (!(workspace_.depths[i] > 0)) continue;
    sum += static_cast<double>(workspace_.depths[i]);
    ++deep;
  }
  work_.ground_distance = deep != 0 ? static_cast<double>(deep) / sum : 0;
}

Status PlaceMemory::load() {
  ILP_TRY(load_camera(wiring_.store, work_.camera));
  ILP_TRY(get(wiring_.store, work_.depth.id, work_.keyframe));
  ILP_TAKE(const bool posed, find(wiring_.store, work_.depth.id, work_.pose));
  if (!posed || work_.pose.state != PoseState::final || !is_pose(work_.pose)) work_.pose.state = PoseState::failed;
  ILP_TRY(load_cells());
  ILP_TRY(load_keyframe_image(wiring_.store, work_.keyframe.id, workspace_.image));
  work_.keeps = true;
  work_.phase = Phase::features;
  return begin_place_features(workspace_.image.view(), wiring_.scratch.as<PlaceScratch>().features,
                              workspace_.features);
}

Status PlaceMemory::find_features() {
  auto& scratch = wiring_.scratch.as<PlaceScratch>();
  ILP_TAKE(work_.keeps, place_features_slice(workspace_.image.view(), part<PlacePart>().features_wanted(),
                                             scratch.harris, scratch.features, workspace_.features));
  if (work_.keeps) return {};
  work_.keeps = true;
  work_.phase = Phase::patches;
  return begin_place_patches(workspace_.image.view(), scratch.harris, scratch.patches, workspace_.patches);
}

Status PlaceMemory::take_patches() {
  auto& scratch = wiring_.scratch.as<PlaceScratch>();
  ILP_TAKE(work_.keeps,
           place_patches_slice(workspace_.image.view(), scratch.harris, scratch.patches, workspace_.patches));
  if (work_.keeps) return {};
  give_depths();
  work_.phase = Phase::search;
  return {};
}

/// Returns the slot whose keyframe makes room; limits::max_places if there is room.
std::size_t PlaceMemory::choose_slot(PlaceRecord& place) const {
  std::size_t slot = 0;
  while (slot < limits::max_places && (workspace_.index.holds(slot) || workspace_.table.at(slot).keyframe_id != 0))
    ++slot;
  std::size_t forgotten = limits::max_places;
  if (slot == limits::max_places || workspace_.table.count() >= places_with_capacity(wiring_.mission)) {
    slot = workspace_.table.least_needed();
    if (slot == limits::max_places) return slot;
    forgotten = slot;
  }
  place.slot = static_cast<std::int32_t>(slot);
  return forgotten;
}

Status PlaceMemory::write_place(const PlaceRecord& place, std::size_t forgotten) {
  if (forgotten < limits::max_places)
    ILP_TRY(erase<PlaceRecord>(wiring_.store, workspace_.table.at(forgotten).keyframe_id));
  if (state_.bare_id != 0) {
    const Status erased = erase<PlaceRecord>(wiring_.store, state_.bare_id);
    if (!erased.ok() && !erased.is(StatusCode::not_found)) return erased;
  }
  ILP_TRY(put(wiring_.store, place));
  if (place.features.bytes != 0) {
    const std::size_t count = workspace_.features.size();
    ILP_TRY(write_blob<PlaceRecord>(wiring_.store, "features", place.id, 0, octets(workspace_.features.data(), count)));
    ILP_TRY(write_blob<PlaceRecord>(wiring_.store, "features", place.id, count * sizeof(PlaceFeature),
                                    octets(workspace_.feature_depths.data(), count)));
  }
  if (place.cells.bytes != 0) {
    ILP_TRY(write_blob<PlaceRecord>(wiring_.store, "cells", place.id, 0,
                                    octets(workspace_.seen.quality.data(), place.cells.bytes)));
  }
  if (place.patches.bytes != 0)
    ILP_TRY(write_blob<PlaceRecord>(wiring_.store, "patches", place.id, 0,
                                    octets(workspace_.patches.data(), workspace_.patches.size())));
  if (work_.mask.id == 0) return {};
  work_.mask.scope = MaskScope::flight;
  ILP_TRY(amend(wiring_.store, work_.mask));
  if (!work_.mask_changed) return {};
  return write_blob<MaskRecord>(wiring_.store, "code", work_.mask.id, 0,
                                {workspace_.mask_bytes.data(), work_.mask.code.bytes});
}

Status PlaceMemory::write_ties(State& after) {
  bool tied = false;
  for (std::size_t i = 0; i < work_.links.size(); ++i) {
    const LinkRecord& link = work_.links[i];
    ILP_TRY(put(wiring_.store, link));
    if (link.points.bytes != 0)
      ILP_TRY(write_blob<LinkRecord>(wiring_.store, "points", link.id, 0,
                                     octets(work_.link_points[i].data(), work_.link_points[i].size())));
    const bool other = link.place_strip_id != work_.keyframe.strip_id;
    if (link.verdict != LinkVerdict::linked || !other) continue;
    PoseRecord place;
    ILP_TRY(part<PlacePart>().measured(link.place_id, place));
    if (place.state != PoseState::final) continue;
    add_link(work_.keyframe.strip_id, linked_world(link, work_.pose, place), after.links);
    tied = true;
  }
  TieRecord tie;
  if (!tied || !tie_strip(after.links, tie)) return {};
  return put(wiring_.store, tie);
}

void PlaceMemory::remember(const PlaceRecord& place, std::size_t forgotten) {
  if (forgotten < limits::max_places) {
    workspace_.table.remove(forgotten);
    static_cast<void>(workspace_.index.remove(forgotten));
  }
  if (place.slot < 0) return;
  const auto slot = static_cast<std::size_t>(place.slot);
  part<PlaceRecall>().fill_vocabulary(slot);
  if (!workspace_.index.insert(slot, place.id, Features(workspace_.features.data(), workspace_.features.size())).ok())
    return;
  if (!workspace_.table.add(slot, PlaceRecall::entry_of(place))) static_cast<void>(workspace_.index.remove(slot));
}

Status PlaceMemory::record() {
  PlaceRecord place;
  place.id = work_.depth.id;
  place.strip_id = work_.depth.strip_id;
  place.candidates = static_cast<std::uint32_t>(work_.compared);
  place.links = static_cast<std::uint32_t>(work_.links.size());
  std::size_t forgotten = limits::max_places;
  if (!workspace_.features.empty()) {
    place.posed = work_.pose.state == PoseState::final;
    std::copy_n(work_.pose.q_cam_from_world, 4, place.q_cam_from_world);
    std::copy_n(work_.pose.centre, 3, place.centre);
    place.ground_distance = work_.ground_distance;
    place.known_before = work_.known_before;
    forgotten = choose_slot(place);
  }
  if (place.slot >= 0) {
    place.features.bytes = static_cast<std::uint32_t>(workspace_.features.size() * bytes_per_feature);
    place.cells.bytes = static_cast<std::uint32_t>(cell_count(workspace_.seen));
    place.patches.bytes = static_cast<std::uint32_t>(workspace_.patches.size() * sizeof(PlacePatch));
  }
  workspace_.after = state_;
  workspace_.after.bare_id = place.slot < 0 ? place.id : 0;
  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(write_place(place, forgotten));
  ILP_TRY(write_ties(workspace_.after));
  ILP_TRY(transaction.commit({place.id, cursor_.second}, workspace_.after, cursor_, state_));
  work_.patience.end_writing();
  remember(place, forgotten);
  work_.phase = Phase::idle;
  return work_.drift;
}

Status PlaceMemory::advance() {
  switch (work_.phase) {
    case Phase::recall:
      return part<PlaceRecall>().recall();
    case Phase::idle:
      break;
    case Phase::load:
      return load();
    case Phase::features:
      return find_features();
    case Phase::patches:
      return take_patches();
    case Phase::search:
      return part<PlaceLinks>().search();
    case Phase::compare:
      return part<PlaceLinks>().compare();
    case Phase::narrow:
      return part<PlaceMarks>().mark_known_ground();
    case Phase::cut:
      return part<PlaceMarks>().cut_mask();
    case Phase::record:
      return record();
  }
  return {};
}

StepResult PlaceMemory::step() {
  // What was found so far is lost then.
  if (wiring_.mission.safe_mode && (work_.phase == Phase::features || work_.phase == Phase::patches))
    work_.phase = Phase::idle;
  work_.keeps = false;
  if (wiring_.mission.safe_mode) return {};
  const bool idle = work_.phase == Phase::idle;
  const Result<bool> picked = idle ? pick() : Result<bool>(true);
  const Status status = idle ? picked.status() : advance();
  work_.keeps = work_.keeps && status.ok();
  if (status.ok()) return {{}, picked.value(), work_.keeps ? Then::keep : Then::go_on};
  if (status.is(StatusCode::loop_contradicts)) return {status, true};
  return work_.patience.failed(work_.phase == Phase::recall ? recall_subject : work_.depth.id, status);
}

}  // namespace ilp
