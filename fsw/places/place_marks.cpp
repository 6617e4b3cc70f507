// Takes ground that earlier keyframes have seen out of the mask of a keyframe.
#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/places/place_blobs.hpp"
#include "fsw/places/place_memory.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// A distance of places, in half sides of the image: corners touch.
constexpr double any_in_common = 3.4;
/// Links and poses put ground within a pixel of its place.
constexpr std::int32_t border_px = 2, sliver_px = 4;
/// Poses of keyframes far apart in the strip say where ground lies if three sigmas are at most a cell.
constexpr double pose_sigmas = 3;
constexpr double largest_pose_error_px = seen_cell_px;
/// The cosine of 0.2 rad, by which a camera turns in a curve and not on a straight strip.
constexpr double straight_on = 0.98;
/// The cosine of 45 degrees between two parts of the camera's way. Behind such a bend, ground beside the way comes into
/// view again that the keyframe before does not show.
constexpr double same_way = 0.7;

}  // namespace

Status PlaceMemory::load_seen(std::int64_t keyframe_id, SeenCells& cells) {
  ILP_TRY(clear_seen_cells(camera_.width, camera_.height, cells));
  PlaceRecord place;
  const Status found = get(store_, keyframe_id, place);
  if (!found.ok()) return is_transient(found) ? found : Status{};
  const std::size_t count = cell_count(cells);
  if (place.cells.bytes != count) return {};
  const Status read =
      read_blob<PlaceRecord>(store_, "cells", keyframe_id, 0, writable_octets(cells.quality.data(), count));
  if (read.ok()) return {};
  ILP_TRY(clear_seen_cells(camera_.width, camera_.height, cells));
  return is_transient(read) ? read : Status{};
}

/// The image makes room for the mask. Where no earlier keyframe shows this ground, nobody needs it.
Status PlaceMemory::load_mask() {
  if (mask_loaded_) return {};
  ILP_TRY(image_.resize(mask_.width, mask_.height));
  ILP_TRY(read_blob<MaskRecord>(store_, "code", mask_.id, 0, {mask_bytes_.data(), mask_.code.bytes}));
  ILP_TRY(decode_mask(mask_bytes_.data(), mask_.code.bytes, image_.view()));
  mask_loaded_ = true;
  return {};
}

/// By one link all keyframes of the earlier strip that stand near say which ground they have seen.
Status PlaceMemory::mark_by(const LinkRecord& link, std::size_t& left, bool& done) {
  if (depth_.verdict != DepthVerdict::ok) {
    if (left > 0) {
      --left;
      return {};
    }
    done = true;
    ILP_TRY(load_mask());
    ILP_TRY(load_seen(link.place_id, other_seen_));
    Mat3 keyframe_from_place;
    for (int i = 0; i < 9; ++i) keyframe_from_place(i / 3, i % 3) = link.keyframe_from_place_px[i];
    const Mat3 place_from_keyframe = keyframe_from_place.inverse();
    if (place_from_keyframe.allFinite()) {
      mark_known_over_plane(image_.view(), place_from_keyframe, other_seen_, known_);
    }
    return {};
  }
  // Without a geometry nothing says how well the other keyframe saw the ground of this one.
  if (link.verdict == LinkVerdict::images_only) return {};
  PoseRecord place;
  ILP_TRY(measured(link.place_id, place));
  if (place.state != PoseState::final) return {};
  const Similarity cam_from_strip = compose(similarity_of(link), similarity_from(cam_from_world(pose_of(place))));
  const bool same = link.place_strip_id == keyframe_.strip_id;
  NearPlaces near;
  table_.find_near(link.place_strip_id, same ? first_chained() - 1 : keyframe_.id - 1, cam_from_strip, ground_distance_,
                   any_in_common, camera_, near);
  done = left < near.size();
  if (done) return mark_seen_by(near[left], cam_from_strip, 0);
  left -= near.size();
  return {};
}

Status PlaceMemory::mark_seen_by(const NearPlace& near, const Similarity& cam_from_strip, double error_px) {
  const std::int64_t id = table_.at(near.slot).keyframe_id;
  PoseRecord pose;
  ILP_TRY(measured(id, pose));
  if (pose.state != PoseState::final) return {};
  ILP_TRY(load_mask());
  ILP_TRY(load_seen(id, other_seen_));
  const Similarity other_from_camera = compose(similarity_from(cam_from_world(pose_of(pose))), inverse(cam_from_strip));
  mark_known({image_.view(), seen_, depths_, camera_}, {other_seen_, other_from_camera, error_px}, mission_.claim_ratio,
             known_);
  return {};
}

/// The ground before the camera, in the middle of the image, in the world of the strip.
Vec3 PlaceMemory::ground_here() const {
  return inverse(cam_from_world(pose_of(pose_))) * Vec3(0, 0, ground_distance_);
}

/// On a straight strip no keyframe comes nearer to an earlier one than the keyframe before it, none turns, and all go
/// the same way.
bool PlaceMemory::comes_back_to(const RememberedPlace& place, const RememberedPlace& before) const {
  const RigidTransform here = cam_from_world(pose_of(pose_));
  const Vec3 ground = ground_of(place);
  if ((ground_here() - ground).norm() < (ground_of(before) - ground).norm()) return true;
  const Vec3 middle = inverse(camera_at(before)).translation;
  const Vec3 way = middle - inverse(camera_at(place)).translation, next = inverse(here).translation - middle;
  if (way.dot(next) < same_way * way.norm() * next.norm()) return true;
  const Mat3 turn = here.rotation * camera_at(place).rotation.transpose();
  return 0.5 * (turn.trace() - 1) < straight_on;
}

/// The keyframe before shows all ground of this one, but for corners: as in a descent, nothing can come back.
bool PlaceMemory::lies_inside(const RememberedPlace& before) const {
  const double half = 0.5 * std::min(camera_.width / camera_.fx, camera_.height / camera_.fy);
  const double apart = (ground_here() - ground_of(before)).norm();
  return apart + half * ground_distance_ <= half * static_cast<double>(before.ground_distance);
}

/// How far the ground may lie from where the poses of this keyframe and an earlier one of the strip put it.
Status PlaceMemory::error_by_poses(const RememberedPlace& place, double& error_px) {
  error_px = 0;
  if (place.keyframe_id > keyframe_.id - chained_keyframes) return {};
  PoseRecord pose;
  ILP_TRY(measured(place.keyframe_id, pose));
  const bool first = place.keyframe_id == keyframe_.id - keyframe_.index;
  const bool stated = pose.state == PoseState::final && has_covariance(pose_) && (first || has_covariance(pose));
  error_px = stated ? pose_sigmas * camera_.fx * ground_error_of_poses(pose_, pose, ground_distance_) : HUGE_VAL;
  return {};
}

/// Ground that left the images of the strip and comes back without a link: the poses say where it is.
Status PlaceMemory::mark_by_poses(std::size_t& left, bool& done) {
  const RememberedPlace* before = table_.newest();
  const bool posed = pose_.state == PoseState::final && ground_distance_ > 0;
  if (!posed || before == nullptr || before->strip_id != keyframe_.strip_id || lies_inside(*before)) return {};
  const auto contradicts = [](const LinkRecord& link) { return link.verdict == LinkVerdict::contradicts_poses; };
  if (std::any_of(links_.begin(), links_.end(), contradicts)) return {};
  const Similarity cam_from_strip = similarity_from(cam_from_world(pose_of(pose_)));
  NearPlaces near;
  table_.find_near(keyframe_.strip_id, keyframe_.id - 2, cam_from_strip, ground_distance_, any_in_common, camera_,
                   near);
  for (const NearPlace& one : near) {
    const RememberedPlace& place = table_.at(one.slot);
    if (!comes_back_to(place, *before)) continue;
    if (left > 0) {
      --left;
      continue;
    }
    done = true;
    double error_px = 0;
    ILP_TRY(error_by_poses(place, error_px));
    return error_px <= largest_pose_error_px ? mark_seen_by(one, cam_from_strip, error_px) : Status{};
  }
  return {};
}

Status PlaceMemory::link_before(std::int64_t keyframe_id, std::int64_t number, LinkRecord& link, bool& found) {
  const Status got = get(store_, link_id(keyframe_id, number), link);
  found = got.ok();
  return found || !is_transient(got) ? Status{} : got;
}

/// Ground of another strip that no link of this keyframe leads to, where one of the keyframes just before does: the
/// chain relates this keyframe to that one.
Status PlaceMemory::mark_by_links_before(std::size_t& left, bool& done) {
  const std::int64_t first = keyframe_.id - keyframe_.index;
  if (pose_.state != PoseState::final || !(ground_distance_ > 0) || first <= 1) return {};
  FixedVector<std::int64_t, chained_keyframes + limits::max_links_per_keyframe> reached;
  for (const LinkRecord& link : links_) {
    if (link.verdict != LinkVerdict::images_only) static_cast<void>(reached.push_back(link.place_strip_id));
  }
  static_cast<void>(reached.push_back(keyframe_.strip_id));
  for (std::int64_t id = keyframe_.id - 1; id >= first && id > keyframe_.id - chained_keyframes && !done; --id) {
    LinkRecord link;
    bool found = true;
    for (std::int64_t number = 0; number < limits::max_links_per_keyframe && !done; ++number) {
      ILP_TRY(link_before(id, number, link, found));
      if (!found) break;
      const bool known = std::find(reached.begin(), reached.end(), link.place_strip_id) != reached.end();
      if (known || link.verdict != LinkVerdict::linked || reached.size() == reached.capacity()) continue;
      static_cast<void>(reached.push_back(link.place_strip_id));
      ILP_TRY(mark_by_link_of(id, link, left, done));
    }
  }
  return {};
}

Status PlaceMemory::mark_by_link_of(std::int64_t linked_id, const LinkRecord& link, std::size_t& left, bool& done) {
  PoseRecord linked, place;
  ILP_TRY(measured(linked_id, linked));
  ILP_TRY(measured(link.place_id, place));
  if (linked.state != PoseState::final || place.state != PoseState::final) return {};
  const Similarity here_from_world = similarity_from(cam_from_world(pose_of(pose_)));
  const Similarity linked_from_here =
      compose(similarity_from(cam_from_world(pose_of(linked))), inverse(here_from_world));
  const double error_px = pose_sigmas * camera_.fx *
                          error_of_link_at(link, linked_from_here * Vec3(0, 0, ground_distance_)) / ground_distance_;
  if (!(error_px <= largest_pose_error_px)) return {};
  const Similarity cam_from_strip =
      compose(inverse(linked_from_here), compose(similarity_of(link), similarity_from(cam_from_world(pose_of(place)))));
  NearPlaces near;
  table_.find_near(link.place_strip_id, keyframe_.id - 1, cam_from_strip, ground_distance_, any_in_common, camera_,
                   near);
  done = left < near.size();
  if (done) return mark_seen_by(near[left], cam_from_strip, error_px);
  left -= near.size();
  return {};
}

Status PlaceMemory::mark_next(bool& done) {
  std::size_t left = marked_++;
  done = false;
  for (std::size_t i = 0; i < links_.size() && !done; ++i) ILP_TRY(mark_by(links_[i], left, done));
  if (done || depth_.verdict != DepthVerdict::ok) return {};
  ILP_TRY(mark_by_links_before(left, done));
  return done ? Status{} : mark_by_poses(left, done);
}

/// By one earlier keyframe.
Status PlaceMemory::mark_known_ground() {
  const bool masked = mask_.code.bytes != 0 && mask_.code.bytes <= mask_bytes_.size();
  bool done = false;
  if (masked) ILP_TRY(mark_next(done));
  if (done) return {};
  marked_ = 0;
  phase_ = mask_loaded_ ? Phase::cut : Phase::record;
  return {};
}

/// Takes the ground that is known out of the mask.
Status PlaceMemory::cut_mask() {
  bool more = false;
  known_before_ = take_known_slice(known_, sliver_px, border_px, image_.view(), marked_++, more);
  if (more) return {};
  phase_ = Phase::record;
  mask_changed_ = known_before_ != 0;
  if (!mask_changed_) return {};
  std::size_t bytes = 0;
  ILP_TRY(encode_mask(image_.view(), mask_bytes_.data(), mask_bytes_.size(), bytes));
  mask_.code.bytes = static_cast<std::uint32_t>(bytes);
  mask_.newly_seen -= std::min(mask_.newly_seen, known_before_);
  return {};
}

}  // namespace ilp
