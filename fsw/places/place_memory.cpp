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

/// The reading of the places after a start, as an input for patience_.
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
    : store_(store), mission_(mission), scratch_(scratch) {}

LastingMemory PlaceMemory::lasting() const {
  const LastingMemory memory =
      LastingMemory(cursor_, state_).of(*this).at_work(patience_, mask_changed_).changed_by_commits();
  if (!keeps_) return memory;
  const auto& scratch = scratch_.as<PlaceScratch>();
  const LastingMemory corners = memory.keeping(scratch.harris.next_row, scratch.harris.strongest);
  return phase_ == Phase::features ? corners.keeping(scratch.features.at_level, scratch.features.corners_found)
                                   : corners.keeping(scratch.patches.corners_found, scratch.patches.corners_found);
}

Status PlaceMemory::pick(bool& picked) {
  ILP_TRY(forget_one(picked));
  if (picked) return {};
  const Status found = next(store_, cursor_.first, depth_);
  if (found.is(StatusCode::not_found)) return {};
  if (found.is(StatusCode::record_damaged)) {
    depth_ = {};
    depth_.id = found.a;
  } else {
    ILP_TRY(found);
  }
  mask_ = {};
  const Status masked = get(store_, depth_.id, mask_);
  if (!masked.ok() && !is_gone(masked) && !patience_.given_up(depth_.id)) return masked;
  // Nobody waits for a mask that is gone. One that was given up is superseded by an empty one.
  if (!is_gone(masked)) mask_.id = depth_.id;
  picked = true;
  static_cast<void>(features_.resize(0));
  patches_.clear();
  links_.clear();
  candidates_.clear();
  compared_ = 0;
  drift_ = {};
  known_.fill(0);
  known_before_ = 0;
  marked_ = 0;
  mask_loaded_ = mask_changed_ = false;
  keyframe_ = {};
  pose_ = {};
  ground_distance_ = 0;
  const bool bare = !found.ok() || !mission_.place_memory || patience_.given_up(depth_.id);
  phase_ = bare ? Phase::record : Phase::load;
  return {};
}

Status PlaceMemory::load_cells() {
  ILP_TRY(clear_seen_cells(camera_.width, camera_.height, seen_));
  const std::size_t cells = cell_count(seen_);
  depths_.fill(0);
  if (depth_.cells.bytes != cells * (1 + sizeof(float))) return {};
  ILP_TRY(read_blob<DepthRecord>(store_, "cells", depth_.id, 0, writable_octets(seen_.quality.data(), cells)));
  return read_blob<DepthRecord>(store_, "cells", depth_.id, cells, writable_octets(depths_.data(), cells));
}

void PlaceMemory::give_depths() {
  std::size_t deep = 0;
  for (std::size_t i = 0; i < features_.size(); ++i)
    feature_depths_[i] = depth_at(depths_, seen_, features_[i].x, features_[i].y);
  for (PlacePatch& patch : patches_) patch.inverse_depth = depth_at(depths_, seen_, patch.x, patch.y);
  double sum = 0;
  for (std::size_t i = 0; i < cell_count(seen_); ++i) {
    if (!(depths_[i] > 0)) continue;
    sum += static_cast<double>(depths_[i]);
    ++deep;
  }
  ground_distance_ = deep != 0 ? static_cast<double>(deep) / sum : 0;
}

Status PlaceMemory::load() {
  ILP_TRY(load_camera(store_, camera_));
  ILP_TRY(get(store_, depth_.id, keyframe_));
  const Status posed = get(store_, depth_.id, pose_);
  if (is_transient(posed)) return posed;
  if (!posed.ok() || pose_.state != PoseState::final || !is_pose(pose_)) pose_.state = PoseState::failed;
  ILP_TRY(load_cells());
  ILP_TRY(load_frame_image(store_, keyframe_.frame_id, image_));
  keeps_ = true;
  phase_ = Phase::features;
  return begin_place_features(image_.view(), scratch_.as<PlaceScratch>().features, features_);
}

std::size_t PlaceMemory::features_wanted() const {
  return loosely_chained() ? limits::max_place_features : limits::place_features;
}

Status PlaceMemory::find_features() {
  auto& scratch = scratch_.as<PlaceScratch>();
  ILP_TRY(place_features_slice(image_.view(), features_wanted(), scratch.harris, scratch.features, features_, keeps_));
  if (keeps_) return {};
  keeps_ = true;
  phase_ = Phase::patches;
  return begin_place_patches(image_.view(), scratch.harris, scratch.patches, patches_);
}

Status PlaceMemory::take_patches() {
  auto& scratch = scratch_.as<PlaceScratch>();
  ILP_TRY(place_patches_slice(image_.view(), scratch.harris, scratch.patches, patches_, keeps_));
  if (keeps_) return {};
  give_depths();
  phase_ = Phase::search;
  return {};
}

/// Whether the chain of pairs says little about this keyframe: it begins a strip, shares less than planned with the
/// keyframe before it, or has no pose.
bool PlaceMemory::loosely_chained() const {
  return !(keyframe_.overlap >= closely_chained) || pose_.state != PoseState::final;
}

/// The first keyframe whose ground the coverage of this strip knows.
std::int64_t PlaceMemory::first_chained() const {
  return std::max(keyframe_.id - keyframe_.index, keyframe_.id - chained_keyframes + 1);
}

/// The first keyframe that is not compared: the chain of this strip relates them.
std::int64_t PlaceMemory::first_too_recent() const {
  return loosely_chained() ? keyframe_.id : first_chained();
}

Status PlaceMemory::tied_to(std::int64_t strip_id, bool& tied, TieRecord& tie) const {
  const Status found = get(store_, strip_id, tie);
  tied = found.ok();
  return found.ok() || !is_transient(found) ? Status{} : found;
}

void PlaceMemory::add_candidate(std::size_t slot) {
  const auto number = static_cast<std::uint16_t>(slot);
  if (table_.at(slot).keyframe_id == 0) return;
  if (std::find(candidates_.begin(), candidates_.end(), number) == candidates_.end()) {
    static_cast<void>(candidates_.push_back(number));
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
    for (const std::size_t slot : table_.newest_slots()) {
      if (slot < limits::max_places) add_candidate(slot);
    }
  }
  if (pose_.state == PoseState::final) {
    const Similarity cam_from_world = similarity_from(ilp::cam_from_world(pose_of(pose_)));
    NearPlaces near;
    table_.find_near(keyframe_.strip_id, first_too_recent() - 1, cam_from_world, ground_distance_, much_in_common,
                     camera_, near);
    add_candidates(near);
    bool tied = false;
    TieRecord tie;
    ILP_TRY(tied_to(keyframe_.strip_id, tied, tie));
    if (tied) {
      table_.find_near(tie.to_strip_id, keyframe_.id - 1, compose(cam_from_world, inverse(similarity_of(tie))),
                       ground_distance_, much_in_common, camera_, near);
      add_candidates(near);
    }
  }
  PlaceCandidates alike;
  ILP_TRY(index_.query(Features(features_.data(), features_.size()), first_too_recent(),
                       scratch_.as<PlaceQueryWorkspace>(), alike));
  add_candidates(alike);
  phase_ = candidates_.empty() ? (features_.empty() ? Phase::record : Phase::narrow) : Phase::compare;
  return {};
}

/// One candidate.
Status PlaceMemory::compare() {
  const RememberedPlace& place = table_.at(candidates_[compared_++]);
  PlaceRecord record;
  const Status found = get(store_, place.keyframe_id, record);
  if (is_transient(found)) return found;
  bool sound = false;
  if (found.ok()) ILP_TRY(load_features(record, sound));
  if (sound) ILP_TRY(link_with(place, record));
  const std::size_t enough = loosely_chained() ? links_.capacity() : enough_links;
  if (compared_ == candidates_.size() || links_.size() >= enough)
    phase_ = (features_.empty() ? Phase::record : Phase::narrow);
  return {};
}

/// The pose of an earlier keyframe; without its errors when its own record was erased with the history, and not final
/// when neither record can be read.
Status PlaceMemory::measured(std::int64_t keyframe_id, PoseRecord& pose) {
  Status found = get(store_, keyframe_id, pose);
  if (!found.ok()) {
    if (is_transient(found)) return found;
    PlaceRecord place;
    found = get(store_, keyframe_id, place);
    if (is_transient(found)) return found;
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
  if (link.strip_id != link.place_strip_id || !(ground_distance_ > 0)) return;
  const LoopError error = loop_error(link, pose_, place);
  const Eigen::Matrix<double, 3, 7> ground = ground_by_step(ground_distance_);
  const Vec3 moved = ground * error.step;
  const Mat3 covariance = ground * error.covariance * ground.transpose();
  const Mat3 information = covariance.inverse();
  link.closing_error = moved.norm() / ground_distance_;
  link.closing_sigma = std::sqrt(covariance.trace()) / ground_distance_;
  const double misfit = moved.dot(information * moved);
  if (!(misfit > largest_misfit)) return;
  link.verdict = LinkVerdict::contradicts_poses;
  const double sigmas = link.closing_sigma > 0 ? link.closing_error / link.closing_sigma : 0;
  drift_ = {StatusCode::loop_contradicts, link.id, static_cast<std::int64_t>(std::min(sigmas, 1e6))};
}

/// Where the newer keyframe sees the ground of the older one's patches.
Status PlaceMemory::register_patches(const PlaceRecord& place, LinkPoints& points) {
  points.clear();
  const std::size_t count = std::min<std::size_t>(place.patches.bytes / sizeof(PlacePatch), older_patches_.capacity());
  static_cast<void>(older_patches_.resize(count));
  const Status read =
      read_blob<PlaceRecord>(store_, "patches", place.id, 0, writable_octets(older_patches_.data(), count));
  if (!read.ok()) return is_transient(read) ? read : Status{};
  ILP_TRY(find_place_patches({older_patches_.data(), count}, image_.view(), match_.plane_newer_from_older, {},
                             scratch_.as<PlaceScratch>().patches, sightings_));
  for (const PatchSighting& seen : sightings_) {
    const PlacePatch& from = older_patches_[seen.patch];
    LinkPoint point;
    if (in_link_units(from.x, point.place_x) && in_link_units(from.y, point.place_y) &&
        in_link_units(seen.x, point.x) && in_link_units(seen.y, point.y)) {
      static_cast<void>(points.push_back(point));
    }
  }
  return {};
}

void PlaceMemory::match_features() {
  matches_.clear();
  for (const PlacePair& pair : match_.pairs) {
    const PlaceFeature& a = older_[pair.older];
    const PlaceFeature& b = features_[pair.newer];
    add_match(a.x, a.y, older_depths_[pair.older], b.x, b.y);
  }
}

void PlaceMemory::match_patches() {
  matches_.clear();
  for (const PatchSighting& seen : sightings_) {
    const PlacePatch& patch = older_patches_[seen.patch];
    add_match(patch.x, patch.y, patch.inverse_depth, seen.x, seen.y);
  }
}

void PlaceMemory::add_match(float older_x, float older_y, float older_depth, float x, float y) {
  const Vec2 from = ideal_from_pixel(camera_, Vec2(static_cast<double>(older_x), static_cast<double>(older_y)));
  const Vec2 to = ideal_from_pixel(camera_, Vec2(static_cast<double>(x), static_cast<double>(y)));
  static_cast<void>(matches_.push_back({from.x(), from.y(), static_cast<double>(older_depth), to.x(), to.y(),
                                        static_cast<double>(depth_at(depths_, seen_, x, y))}));
}

/// By registered patches, or by features where too few patches agree.
Status PlaceMemory::relate(std::uint64_t link_id, LinkGeometry& geometry) {
  LinkGeometryParams params;
  params.seed = mix64(mission_.seed) ^ link_id;
  match_patches();
  params.threshold_px = registered_threshold_px;
  params.feature_sigma_px = registered_sigma_px;
  if (estimate_link(matches_, camera_, params, scratch_.as<LinkGeometryWorkspace>(), geometry).ok()) return {};
  match_features();
  params.threshold_px = LinkGeometryParams{}.threshold_px;
  params.feature_sigma_px = LinkGeometryParams{}.feature_sigma_px;
  return estimate_link(matches_, camera_, params, scratch_.as<LinkGeometryWorkspace>(), geometry);
}

Status PlaceMemory::link_with(const RememberedPlace& place, const PlaceRecord& record) {
  ILP_TRY(verify_place(Features(older_.data(), older_.size()), Features(features_.data(), features_.size()), {},
                       scratch_.as<PlaceScratch>().match, match_));
  if (match_.verdict != PlaceVerdict::verified) return {};
  LinkPoints& points = link_points_[links_.size()];
  ILP_TRY(register_patches(record, points));
  LinkRecord link;
  link.id = link_id(keyframe_.id, static_cast<std::int64_t>(links_.size()));
  link.keyframe_id = keyframe_.id;
  link.place_id = place.keyframe_id;
  link.strip_id = keyframe_.strip_id;
  link.place_strip_id = place.strip_id;
  link.matches = static_cast<std::uint32_t>(match_.pairs.size());
  link.inliers = static_cast<std::uint32_t>(std::max(match_.inliers, 0));
  link.rms_px = match_.residual_px;
  std::copy_n(match_.plane_newer_from_older, 9, link.keyframe_from_place_px);
  link.verdict = LinkVerdict::images_only;

  LinkGeometry geometry;
  const Status related = relate(static_cast<std::uint64_t>(link.id), geometry);
  PoseRecord pose;
  ILP_TRY(measured(place.keyframe_id, pose));
  if (related.ok() && pose_.state == PoseState::final && pose.state == PoseState::final) {
    link.verdict = LinkVerdict::linked;
    link.matches = static_cast<std::uint32_t>(matches_.size());
    link.inliers = geometry.inliers;
    link.rms_px = geometry.rms_px;
    quaternion_from_rotation(geometry.keyframe_from_place.rotation, link.q_keyframe_from_place);
    for (int i = 0; i < 3; ++i) link.translation[i] = geometry.keyframe_from_place.translation(i);
    link.scale = geometry.keyframe_from_place.scale;
    pack_covariance(geometry.covariance, link.covariance);
    judge(link, pose);
  }
  link.points.bytes = static_cast<std::uint32_t>(points.size() * sizeof(LinkPoint));
  static_cast<void>(links_.push_back(link));
  return {};
}

/// `forgotten`: the slot whose keyframe makes room; limits::max_places if there is room.
Status PlaceMemory::choose_slot(PlaceRecord& place, std::size_t& forgotten) {
  forgotten = limits::max_places;
  if (features_.empty()) return {};
  std::size_t slot = 0;
  while (slot < limits::max_places && (index_.holds(slot) || table_.at(slot).keyframe_id != 0)) ++slot;
  const bool full = slot == limits::max_places || table_.count() >= places_with_room(mission_);
  if (full) {
    forgotten = table_.least_needed();
    if (forgotten == limits::max_places) return {};
    slot = forgotten;
  }
  place.slot = static_cast<std::int32_t>(slot);
  return {};
}

Status PlaceMemory::write_place(const PlaceRecord& place, std::size_t forgotten) {
  if (forgotten < limits::max_places) ILP_TRY(erase<PlaceRecord>(store_, table_.at(forgotten).keyframe_id));
  if (state_.bare_id != 0) {
    const Status erased = erase<PlaceRecord>(store_, state_.bare_id);
    if (!erased.ok() && !erased.is(StatusCode::not_found)) return erased;
  }
  ILP_TRY(put(store_, place));
  if (place.features.bytes != 0) {
    const std::size_t count = features_.size();
    ILP_TRY(write_blob<PlaceRecord>(store_, "features", place.id, 0, octets(features_.data(), count)));
    ILP_TRY(write_blob<PlaceRecord>(store_, "features", place.id, count * sizeof(PlaceFeature),
                                    octets(feature_depths_.data(), count)));
  }
  if (place.cells.bytes != 0) {
    ILP_TRY(write_blob<PlaceRecord>(store_, "cells", place.id, 0, octets(seen_.quality.data(), place.cells.bytes)));
  }
  if (place.patches.bytes != 0)
    ILP_TRY(write_blob<PlaceRecord>(store_, "patches", place.id, 0, octets(patches_.data(), patches_.size())));
  if (mask_.id == 0) return {};
  mask_.scope = MaskScope::flight;
  ILP_TRY(amend(store_, mask_));
  if (!mask_changed_) return {};
  return write_blob<MaskRecord>(store_, "code", mask_.id, 0, {mask_bytes_.data(), mask_.code.bytes});
}

Status PlaceMemory::write_ties(State& after) {
  bool tied = false;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const LinkRecord& link = links_[i];
    ILP_TRY(put(store_, link));
    if (link.points.bytes != 0)
      ILP_TRY(
          write_blob<LinkRecord>(store_, "points", link.id, 0, octets(link_points_[i].data(), link_points_[i].size())));
    const bool other = link.place_strip_id != keyframe_.strip_id;
    if (link.verdict != LinkVerdict::linked || !other) continue;
    PoseRecord place;
    ILP_TRY(measured(link.place_id, place));
    if (place.state != PoseState::final) continue;
    add_link(keyframe_.strip_id, linked_world(link, pose_, place), after.links);
    tied = true;
  }
  TieRecord tie;
  if (!tied || !tie_strip(after.links, tie)) return {};
  return put(store_, tie);
}

void PlaceMemory::remember(const PlaceRecord& place, std::size_t forgotten) {
  if (forgotten < limits::max_places) {
    table_.remove(forgotten);
    static_cast<void>(index_.remove(forgotten));
  }
  if (place.slot < 0) return;
  const auto slot = static_cast<std::size_t>(place.slot);
  fill_vocabulary(slot);
  if (!index_.insert(slot, place.id, Features(features_.data(), features_.size())).ok()) return;
  if (!table_.add(slot, entry_of(place))) static_cast<void>(index_.remove(slot));
}

Status PlaceMemory::record() {
  PlaceRecord place;
  place.id = depth_.id;
  place.strip_id = depth_.strip_id;
  place.candidates = static_cast<std::uint32_t>(compared_);
  place.links = static_cast<std::uint32_t>(links_.size());
  std::size_t forgotten = limits::max_places;
  if (!features_.empty()) {
    place.posed = pose_.state == PoseState::final;
    std::copy_n(pose_.q_cam_from_world, 4, place.q_cam_from_world);
    std::copy_n(pose_.centre, 3, place.centre);
    place.ground_distance = ground_distance_;
    place.known_before = known_before_;
    ILP_TRY(choose_slot(place, forgotten));
  }
  if (place.slot >= 0) {
    place.features.bytes = static_cast<std::uint32_t>(features_.size() * bytes_per_feature);
    place.cells.bytes = static_cast<std::uint32_t>(cell_count(seen_));
    place.patches.bytes = static_cast<std::uint32_t>(patches_.size() * sizeof(PlacePatch));
  }
  after_ = state_;
  after_.bare_id = place.slot < 0 ? place.id : 0;
  patience_.begin_writing();
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(write_place(place, forgotten));
  ILP_TRY(write_ties(after_));
  ILP_TRY(transaction.commit({place.id, cursor_.second}, after_, cursor_, state_));
  patience_.end_writing();
  remember(place, forgotten);
  phase_ = Phase::idle;
  return drift_;
}

Status PlaceMemory::advance(bool& picked) {
  switch (phase_) {
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
  if (mission_.safe_mode && (phase_ == Phase::features || phase_ == Phase::patches)) phase_ = Phase::idle;
  keeps_ = false;
  if (mission_.safe_mode) return {};
  bool pending = true;
  const Status status = advance(pending);
  keeps_ = keeps_ && status.ok();
  if (status.ok()) return {{}, pending, keeps_ ? Then::keep : Then::go_on};
  if (status.is(StatusCode::loop_contradicts)) return {status, true};
  return patience_.failed(phase_ == Phase::recall ? recall_subject : depth_.id, status);
}

}  // namespace ilp
