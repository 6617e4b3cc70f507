#include "fsw/places/place_memory.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/places/place_blobs.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/place_room.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// The reading of the places after a start, as an input for work_.patience.
constexpr std::int64_t recall_subject = -1;
/// Overlap from which the chain determines a keyframe's pose well.
constexpr double closely_chained = 0.7;
/// Where the chain is close, more links hardly make the poses better.
constexpr std::size_t enough_links = 3;
/// A distance of places, in half sides of the image.
constexpr double much_in_common = 1;
/// 99.9 % of the squared errors of three coordinates lie below 16.3. The pose errors are stated along the strip only,
/// so that three times the sigma is allowed.
constexpr double largest_misfit = 3 * 3 * 16.3;
/// Patches are registered to a tenth of a pixel; the depths of their cells add their relief.
constexpr double registered_threshold_px = 2.5, registered_sigma_px = 0.3;

/// 0 where there is no ground.
float depth_at(const CellDepths& depths, const SeenCells& cells, float x, float y) {
  const auto column = static_cast<std::int32_t>(x) / seen_cell_px;
  const auto row = static_cast<std::int32_t>(y) / seen_cell_px;
  if (column < 0 || row < 0 || column >= cells.columns || row >= cells.rows) return 0;
  return depths[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells.columns) +
                static_cast<std::size_t>(column)];
}

/// False outside the image that the units can name.
bool in_link_units(float px, std::uint16_t& units) {
  const double scaled = std::floor(static_cast<double>(px) * link_points_per_px + 0.5);
  if (!(scaled >= 0 && scaled <= 65535)) return false;
  units = static_cast<std::uint16_t>(scaled);
  return true;
}

static_assert(sizeof(PlaceRecord) + limits::max_place_features * bytes_per_feature +
                  limits::max_place_patches * sizeof(PlacePatch) + max_seen_cells <=
              most_place_bytes);

/// A pose that a record may hold. What a flipped bit has made of it must not reach the masks of other keyframes.
bool is_pose(const PoseRecord& pose) {
  const RigidTransform camera = cam_from_world(pose_of(pose));
  return camera.rotation.allFinite() && camera.translation.allFinite();
}

}  // namespace

constexpr CheckpointForm PlaceMemory::checkpoint = checkpoint_form<State>(component_id);

PlaceMemory::PlaceMemory(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, mission, scratch} {}

LastingMemory PlaceMemory::lasting() const {
  const LastingMemory memory =
      LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_).changed_by_commits();
  if (!work_.keeps) return memory;
  const auto& scratch = wiring_.scratch.as<PlaceScratch>();
  const LastingMemory corners = memory.keeping(scratch.harris.progress);
  return work_.phase == Phase::features ? corners.keeping(scratch.features.progress)
                                        : corners.keeping(scratch.patches.corners_found);
}

Status PlaceMemory::pick(bool& picked) {
  ILP_TRY(forget_one(picked));
  if (picked) return {};
  const Status found = next(wiring_.store, cursor_.first, work_.depth);
  if (found.is(StatusCode::not_found)) return {};
  if (found.is(StatusCode::record_damaged)) {
    work_.depth = {};
    work_.depth.id = found.a;
  } else {
    ILP_TRY(found);
  }
  work_.mask = {};
  const Status masked = get(wiring_.store, work_.depth.id, work_.mask);
  if (!masked.ok() && !is_gone(masked) && !work_.patience.given_up(work_.depth.id)) return masked;
  // Nobody waits for a mask that is gone. One that was given up is superseded by an empty one.
  if (!is_gone(masked)) work_.mask.id = work_.depth.id;
  picked = true;
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
  const bool bare = !found.ok() || !wiring_.mission.place_memory || work_.patience.given_up(work_.depth.id);
  work_.phase = bare ? Phase::record : Phase::load;
  return {};
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
  const Status posed = get(wiring_.store, work_.depth.id, work_.pose);
  if (!posed.ok() && is_transient(posed)) return posed;
  if (!posed.ok() || work_.pose.state != PoseState::final || !is_pose(work_.pose)) work_.pose.state = PoseState::failed;
  ILP_TRY(load_cells());
  ILP_TRY(load_frame_image(wiring_.store, work_.keyframe.frame_id, workspace_.image));
  work_.keeps = true;
  work_.phase = Phase::features;
  return begin_place_features(workspace_.image.view(), wiring_.scratch.as<PlaceScratch>().features,
                              workspace_.features);
}

std::size_t PlaceMemory::features_wanted() const {
  return loosely_chained() ? limits::max_place_features : limits::place_features;
}

Status PlaceMemory::find_features() {
  auto& scratch = wiring_.scratch.as<PlaceScratch>();
  ILP_TRY(place_features_slice(workspace_.image.view(), features_wanted(), scratch.harris, scratch.features,
                               workspace_.features, work_.keeps));
  if (work_.keeps) return {};
  work_.keeps = true;
  work_.phase = Phase::patches;
  return begin_place_patches(workspace_.image.view(), scratch.harris, scratch.patches, workspace_.patches);
}

Status PlaceMemory::take_patches() {
  auto& scratch = wiring_.scratch.as<PlaceScratch>();
  ILP_TRY(
      place_patches_slice(workspace_.image.view(), scratch.harris, scratch.patches, workspace_.patches, work_.keeps));
  if (work_.keeps) return {};
  give_depths();
  work_.phase = Phase::search;
  return {};
}

/// Whether the chain of pairs says little about this keyframe: it begins a strip, shares less than planned with the
/// keyframe before it, or has no pose.
bool PlaceMemory::loosely_chained() const {
  return !(work_.keyframe.overlap >= closely_chained) || work_.pose.state != PoseState::final;
}

/// The first keyframe whose ground the coverage of this strip knows.
std::int64_t PlaceMemory::first_chained() const {
  return std::max(work_.keyframe.id - work_.keyframe.index, work_.keyframe.id - chained_keyframes + 1);
}

/// The first keyframe that is not compared: the chain of this strip relates them.
std::int64_t PlaceMemory::first_too_recent() const {
  return loosely_chained() ? work_.keyframe.id : first_chained();
}

Status PlaceMemory::tied_to(std::int64_t strip_id, bool& tied, TieRecord& tie) const {
  const Status found = get(wiring_.store, strip_id, tie);
  tied = found.ok();
  return found.ok() || !is_transient(found) ? Status{} : found;
}

void PlaceMemory::add_candidate(std::size_t slot) {
  const auto number = static_cast<std::uint16_t>(slot);
  if (workspace_.table.at(slot).keyframe_id == 0) return;
  if (std::find(work_.candidates.begin(), work_.candidates.end(), number) == work_.candidates.end()) {
    static_cast<void>(work_.candidates.push_back(number));
  }
}

/// Of the places, which stand in the order of what they promise, the first.
template <typename Places>
void PlaceMemory::add_candidates(const Places& places) {
  const std::size_t most = loosely_chained() ? limits::max_place_candidates : limits::place_candidates;
  for (std::size_t i = 0; i < places.size() && i < most; ++i) add_candidate(places[i].slot);
}

Status PlaceMemory::search() {
  if (loosely_chained()) {
    for (const std::size_t slot : workspace_.table.newest_slots()) {
      if (slot < limits::max_places) add_candidate(slot);
    }
  }
  if (work_.pose.state == PoseState::final) {
    const Similarity cam_from_world = similarity_from(ilp::cam_from_world(pose_of(work_.pose)));
    NearPlaces near;
    workspace_.table.find_near(work_.keyframe.strip_id, first_too_recent() - 1, cam_from_world, work_.ground_distance,
                               much_in_common, work_.camera, near);
    add_candidates(near);
    bool tied = false;
    TieRecord tie;
    ILP_TRY(tied_to(work_.keyframe.strip_id, tied, tie));
    if (tied) {
      workspace_.table.find_near(tie.to_strip_id, work_.keyframe.id - 1,
                                 compose(cam_from_world, inverse(similarity_of(tie))), work_.ground_distance,
                                 much_in_common, work_.camera, near);
      add_candidates(near);
    }
  }
  PlaceCandidates alike;
  ILP_TRY(workspace_.index.query(Features(workspace_.features.data(), workspace_.features.size()), first_too_recent(),
                                 wiring_.scratch.as<PlaceQueryWorkspace>(), alike));
  add_candidates(alike);
  work_.phase =
      work_.candidates.empty() ? (workspace_.features.empty() ? Phase::record : Phase::narrow) : Phase::compare;
  return {};
}

/// One candidate.
Status PlaceMemory::compare() {
  const RememberedPlace& place = workspace_.table.at(work_.candidates[work_.compared++]);
  PlaceRecord record;
  const Status found = get(wiring_.store, place.keyframe_id, record);
  if (!found.ok() && is_transient(found)) return found;
  bool sound = false;
  if (found.ok()) ILP_TRY(load_features(record, sound));
  if (sound) ILP_TRY(link_with(place, record));
  const std::size_t enough = loosely_chained() ? work_.links.capacity() : enough_links;
  if (work_.compared == work_.candidates.size() || work_.links.size() >= enough)
    work_.phase = (workspace_.features.empty() ? Phase::record : Phase::narrow);
  return {};
}

/// The pose of an earlier keyframe; without its errors when its own record was erased with the history, and not final
/// when neither record can be read.
Status PlaceMemory::measured(std::int64_t keyframe_id, PoseRecord& pose) {
  Status found = get(wiring_.store, keyframe_id, pose);
  if (!found.ok()) {
    if (is_transient(found)) return found;
    PlaceRecord place;
    found = get(wiring_.store, keyframe_id, place);
    if (!found.ok() && is_transient(found)) return found;
    pose = {};
    pose.id = place.id;
    pose.strip_id = place.strip_id;
    pose.state = found.ok() && place.posed ? PoseState::final : PoseState::failed;
    std::copy_n(place.q_cam_from_world, 4, pose.q_cam_from_world);
    std::copy_n(place.centre, 3, pose.centre);
  }
  if (!is_pose(pose)) pose.state = PoseState::failed;
  return {};
}

/// Inside a strip: whether the link agrees with the poses, by where they put the ground in the middle of the image.
void PlaceMemory::judge(LinkRecord& link, const PoseRecord& place) {
  if (link.strip_id != link.place_strip_id || !(work_.ground_distance > 0)) return;
  const LoopError error = loop_error(link, work_.pose, place);
  const Eigen::Matrix<double, 3, 7> ground = ground_by_step(work_.ground_distance);
  const Vec3 moved = ground * error.step;
  const Mat3 covariance = ground * error.covariance * ground.transpose();
  const Mat3 information = covariance.inverse();
  link.closing_error = moved.norm() / work_.ground_distance;
  link.closing_sigma = std::sqrt(covariance.trace()) / work_.ground_distance;
  const double misfit = moved.dot(information * moved);
  if (!(misfit > largest_misfit)) return;
  link.verdict = LinkVerdict::contradicts_poses;
  const double sigmas = link.closing_sigma > 0 ? link.closing_error / link.closing_sigma : 0;
  work_.drift = {StatusCode::loop_contradicts, link.id, static_cast<std::int64_t>(std::min(sigmas, 1e6))};
}

/// Where the newer keyframe sees the ground of the older one's patches.
Status PlaceMemory::register_patches(const PlaceRecord& place, LinkPoints& points) {
  points.clear();
  const std::size_t count =
      std::min<std::size_t>(place.patches.bytes / sizeof(PlacePatch), workspace_.older_patches.capacity());
  static_cast<void>(workspace_.older_patches.resize(count));
  const Status read = read_blob<PlaceRecord>(wiring_.store, "patches", place.id, 0,
                                             writable_octets(workspace_.older_patches.data(), count));
  if (!read.ok()) return is_transient(read) ? read : Status{};
  ILP_TRY(find_place_patches({workspace_.older_patches.data(), count}, workspace_.image.view(),
                             workspace_.match.plane_newer_from_older, {}, wiring_.scratch.as<PlaceScratch>().patches,
                             workspace_.sightings));
  for (const PatchSighting& seen : workspace_.sightings) {
    const PlacePatch& from = workspace_.older_patches[seen.patch];
    LinkPoint point;
    if (in_link_units(from.x, point.place_x) && in_link_units(from.y, point.place_y) &&
        in_link_units(seen.x, point.x) && in_link_units(seen.y, point.y)) {
      static_cast<void>(points.push_back(point));
    }
  }
  return {};
}

void PlaceMemory::match_features() {
  workspace_.matches.clear();
  for (const PlacePair& pair : workspace_.match.pairs) {
    const PlaceFeature& a = workspace_.older[pair.older];
    const PlaceFeature& b = workspace_.features[pair.newer];
    add_match(a.x, a.y, workspace_.older_depths[pair.older], b.x, b.y);
  }
}

void PlaceMemory::match_patches() {
  workspace_.matches.clear();
  for (const PatchSighting& seen : workspace_.sightings) {
    const PlacePatch& patch = workspace_.older_patches[seen.patch];
    add_match(patch.x, patch.y, patch.inverse_depth, seen.x, seen.y);
  }
}

void PlaceMemory::add_match(float older_x, float older_y, float older_depth, float x, float y) {
  const Vec2 from = ideal_from_pixel(work_.camera, Vec2(static_cast<double>(older_x), static_cast<double>(older_y)));
  const Vec2 to = ideal_from_pixel(work_.camera, Vec2(static_cast<double>(x), static_cast<double>(y)));
  static_cast<void>(
      workspace_.matches.push_back({from.x(), from.y(), static_cast<double>(older_depth), to.x(), to.y(),
                                    static_cast<double>(depth_at(workspace_.depths, workspace_.seen, x, y))}));
}

/// By registered patches, or by features where too few patches agree.
Status PlaceMemory::relate(std::uint64_t link_id, LinkGeometry& geometry) {
  LinkGeometryParams params;
  params.seed = mix64(wiring_.mission.seed) ^ link_id;
  match_patches();
  params.threshold_px = registered_threshold_px;
  params.feature_sigma_px = registered_sigma_px;
  if (estimate_link(workspace_.matches, work_.camera, params, wiring_.scratch.as<LinkGeometryWorkspace>(), geometry)
          .ok())
    return {};
  match_features();
  params.threshold_px = LinkGeometryParams{}.threshold_px;
  params.feature_sigma_px = LinkGeometryParams{}.feature_sigma_px;
  return estimate_link(workspace_.matches, work_.camera, params, wiring_.scratch.as<LinkGeometryWorkspace>(), geometry);
}

Status PlaceMemory::link_with(const RememberedPlace& place, const PlaceRecord& record) {
  ILP_TRY(verify_place(Features(workspace_.older.data(), workspace_.older.size()),
                       Features(workspace_.features.data(), workspace_.features.size()), {},
                       wiring_.scratch.as<PlaceScratch>().match, workspace_.match));
  if (workspace_.match.verdict != PlaceVerdict::verified) return {};
  LinkPoints& points = work_.link_points[work_.links.size()];
  ILP_TRY(register_patches(record, points));
  LinkRecord link;
  link.id = link_id(work_.keyframe.id, static_cast<std::int64_t>(work_.links.size()));
  link.keyframe_id = work_.keyframe.id;
  link.place_id = place.keyframe_id;
  link.strip_id = work_.keyframe.strip_id;
  link.place_strip_id = place.strip_id;
  link.matches = static_cast<std::uint32_t>(workspace_.match.pairs.size());
  link.inliers = static_cast<std::uint32_t>(std::max(workspace_.match.inliers, 0));
  link.rms_px = workspace_.match.residual_px;
  std::copy_n(workspace_.match.plane_newer_from_older, 9, link.keyframe_from_place_px);
  link.verdict = LinkVerdict::images_only;

  LinkGeometry geometry;
  const Status related = relate(static_cast<std::uint64_t>(link.id), geometry);
  PoseRecord pose;
  ILP_TRY(measured(place.keyframe_id, pose));
  if (related.ok() && work_.pose.state == PoseState::final && pose.state == PoseState::final) {
    link.verdict = LinkVerdict::linked;
    link.matches = static_cast<std::uint32_t>(workspace_.matches.size());
    link.inliers = geometry.inliers;
    link.rms_px = geometry.rms_px;
    quaternion_from_rotation(geometry.keyframe_from_place.rotation, link.q_keyframe_from_place);
    for (int i = 0; i < 3; ++i) link.translation[i] = geometry.keyframe_from_place.translation(i);
    link.scale = geometry.keyframe_from_place.scale;
    pack_covariance(geometry.covariance, link.covariance);
    judge(link, pose);
  }
  link.points.bytes = static_cast<std::uint32_t>(points.size() * sizeof(LinkPoint));
  static_cast<void>(work_.links.push_back(link));
  return {};
}

/// `forgotten`: the slot whose keyframe makes room; limits::max_places if there is room.
Status PlaceMemory::choose_slot(PlaceRecord& place, std::size_t& forgotten) {
  forgotten = limits::max_places;
  if (workspace_.features.empty()) return {};
  std::size_t slot = 0;
  while (slot < limits::max_places && (workspace_.index.holds(slot) || workspace_.table.at(slot).keyframe_id != 0))
    ++slot;
  const bool full = slot == limits::max_places || workspace_.table.count() >= places_with_room(wiring_.mission);
  if (full) {
    forgotten = workspace_.table.least_needed();
    if (forgotten == limits::max_places) return {};
    slot = forgotten;
  }
  place.slot = static_cast<std::int32_t>(slot);
  return {};
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
    ILP_TRY(measured(link.place_id, place));
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
  fill_vocabulary(slot);
  if (!workspace_.index.insert(slot, place.id, Features(workspace_.features.data(), workspace_.features.size())).ok())
    return;
  if (!workspace_.table.add(slot, entry_of(place))) static_cast<void>(workspace_.index.remove(slot));
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
    ILP_TRY(choose_slot(place, forgotten));
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

Status PlaceMemory::advance(bool& picked) {
  switch (work_.phase) {
    case Phase::recall:
      return recall();
    case Phase::idle:
      return pick(picked);
    case Phase::load:
      return load();
    case Phase::features:
      return find_features();
    case Phase::patches:
      return take_patches();
    case Phase::search:
      return search();
    case Phase::compare:
      return compare();
    case Phase::narrow:
      return mark_known_ground();
    case Phase::cut:
      return cut_mask();
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
  bool pending = true;
  const Status status = advance(pending);
  work_.keeps = work_.keeps && status.ok();
  if (status.ok()) return {{}, pending, work_.keeps ? Then::keep : Then::go_on};
  if (status.is(StatusCode::loop_contradicts)) return {status, true};
  return work_.patience.failed(work_.phase == Phase::recall ? recall_subject : work_.depth.id, status);
}

}  // namespace ilp
