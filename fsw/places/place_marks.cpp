#include "fsw/places/place_marks.hpp"

#include <algorithm>
#include <cmath>
#include "fsw/base/math.hpp"
#include "fsw/places/place_blobs.hpp"
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

Status PlaceMarks::load_seen(std::int64_t keyframe_id, SeenCells& cells) {
  ILP_TRY(clear_seen_cells(work_.camera.width, work_.camera.height, cells));
  PlaceRecord place;
  ILP_TAKE(const bool found, find(wiring_.store, keyframe_id, place));
  const std::size_t count = cell_count(cells);
  if (!found || place.cells.bytes != count) return {};
  ILP_TAKE(const bool whole, found_by(read_blob<PlaceRecord>(wiring_.store, "cells", keyframe_id, 0,
                                                             writable_octets(cells.quality.data(), count))));
  return whole ? Status{} : clear_seen_cells(work_.camera.width, work_.camera.height, cells);
}

/// The image makes room for the mask. Where no earlier keyframe shows this ground, nobody needs it.
Status PlaceMarks::load_mask() {
  if (work_.mask_loaded) return {};
  ILP_TRY(workspace_.image.resize(work_.mask.width, work_.mask.height));
  ILP_TRY(read_blob<MaskRecord>(wiring_.store, "code", work_.mask.id, 0,
                                {workspace_.mask_bytes.data(), work_.mask.code.bytes}));
  ILP_TRY(decode_mask(workspace_.mask_bytes.data(), work_.mask.code.bytes, workspace_.image.view()));
  work_.mask_loaded = true;
  return {};
}

/// By one link all keyframes of the earlier strip that stand near say which ground they have seen.
Result<bool> PlaceMarks::mark_by(const LinkRecord& link, std::size_t& left) {
  if (work_.depth.verdict != DepthVerdict::ok) {
    if (left > 0) {
      --left;
      return false;
    }
    ILP_TRY(load_mask());
    ILP_TRY(load_seen(link.place_id, workspace_.other_seen));
    Mat3 keyframe_from_place;
    for (int i = 0; i < 9; ++i) keyframe_from_place(i / 3, i % 3) = link.keyframe_from_place_px[i];
    const Mat3 place_from_keyframe = keyframe_from_place.inverse();
    if (place_from_keyframe.allFinite()) {
      mark_known_over_plane(workspace_.image.view(), place_from_keyframe, workspace_.other_seen, workspace_.known);
    }
    return true;
  }
  // Without a geometry nothing says how well the other keyframe saw the ground of this one.
  if (link.verdict == LinkVerdict::images_only) return false;
  PoseRecord place;
  ILP_TRY(measured(link.place_id, place));
  if (place.state != PoseState::final) return false;
  const Similarity cam_from_strip = compose(similarity_of(link), similarity_from(cam_from_world(pose_of(place))));
  const bool same = link.place_strip_id == work_.keyframe.strip_id;
  NearPlaces near;
  workspace_.table.find_near(link.place_strip_id, same ? first_chained() - 1 : work_.keyframe.id - 1, cam_from_strip,
                             work_.ground_distance, any_in_common, work_.camera, near);
  return mark_by_one_of(near, cam_from_strip, 0, left);
}

Result<bool> PlaceMarks::mark_by_one_of(const NearPlaces& near, const Similarity& cam_from_strip, double error_px,
                                        std::size_t& left) {
  if (left >= near.size()) {
    left -= near.size();
    return false;
  }
  ILP_TRY(mark_seen_by(near[left], cam_from_strip, error_px));
  return true;
}

Status PlaceMarks::mark_seen_by(const NearPlace& near, const Similarity& cam_from_strip, double error_px) {
  const std::int64_t id = workspace_.table.at(near.slot).keyframe_id;
  PoseRecord pose;
  ILP_TRY(measured(id, pose));
  if (pose.state != PoseState::final) return {};
  ILP_TRY(load_mask());
  ILP_TRY(load_seen(id, workspace_.other_seen));
  const Similarity other_from_camera = compose(similarity_from(cam_from_world(pose_of(pose))), inverse(cam_from_strip));
  mark_known({workspace_.image.view(), workspace_.seen, workspace_.depths, work_.camera},
             {workspace_.other_seen, other_from_camera, error_px}, wiring_.mission.claim_ratio, workspace_.known);
  return {};
}

/// The ground before the camera, in the middle of the image, in the world of the strip.
Vec3 PlaceMarks::ground_here() const {
  return inverse(cam_from_world(pose_of(work_.pose))) * Vec3(0, 0, work_.ground_distance);
}

/// On a straight strip no keyframe comes nearer to an earlier one than the keyframe before it, none turns, and all go
/// the same way.
bool PlaceMarks::comes_back_to(const RememberedPlace& place, const RememberedPlace& before) const {
  const RigidTransform here = cam_from_world(pose_of(work_.pose));
  const Vec3 ground = ground_of(place);
  if ((ground_here() - ground).norm() < (ground_of(before) - ground).norm()) return true;
  const Vec3 middle = inverse(camera_at(before)).translation;
  const Vec3 way = middle - inverse(camera_at(place)).translation, next = inverse(here).translation - middle;
  if (way.dot(next) < same_way * way.norm() * next.norm()) return true;
  const Mat3 turn = here.rotation * camera_at(place).rotation.transpose();
  return 0.5 * (turn.trace() - 1) < straight_on;
}

/// The keyframe before shows all ground of this one, but for corners: as in a descent, nothing can come back.
bool PlaceMarks::lies_inside(const RememberedPlace& before) const {
  const double half = 0.5 * std::min(work_.camera.width / work_.camera.fx, work_.camera.height / work_.camera.fy);
  const double apart = (ground_here() - ground_of(before)).norm();
  return apart + half * work_.ground_distance <= half * static_cast<double>(before.ground_distance);
}

/// How far the ground may lie from where the poses of this keyframe and an earlier one of the strip put it.
Result<double> PlaceMarks::error_by_poses(const RememberedPlace& place) {
  if (place.keyframe_id > work_.keyframe.id - chained_keyframes) return 0.0;
  PoseRecord pose;
  ILP_TRY(measured(place.keyframe_id, pose));
  const bool first = place.keyframe_id == work_.keyframe.id - work_.keyframe.index;
  const bool stated = pose.state == PoseState::final && has_covariance(work_.pose) && (first || has_covariance(pose));
  if (!stated) return HUGE_VAL;
  return pose_sigmas * work_.camera.fx * ground_error_of_poses(work_.pose, pose, work_.ground_distance);
}

/// Ground that left the images of the strip and comes back without a link: the poses say where it is.
Result<bool> PlaceMarks::mark_by_poses(std::size_t& left) {
  const RememberedPlace* before = workspace_.table.newest();
  const bool posed = work_.pose.state == PoseState::final && work_.ground_distance > 0;
  if (!posed || before == nullptr || before->strip_id != work_.keyframe.strip_id || lies_inside(*before)) return false;
  const auto contradicts = [](const LinkRecord& link) { return link.verdict == LinkVerdict::contradicts_poses; };
  if (std::any_of(work_.links.begin(), work_.links.end(), contradicts)) return false;
  const Similarity cam_from_strip = similarity_from(cam_from_world(pose_of(work_.pose)));
  NearPlaces near;
  workspace_.table.find_near(work_.keyframe.strip_id, work_.keyframe.id - 2, cam_from_strip, work_.ground_distance,
                             any_in_common, work_.camera, near);
  for (const NearPlace& one : near) {
    const RememberedPlace& place = workspace_.table.at(one.slot);
    if (!comes_back_to(place, *before)) continue;
    if (left > 0) {
      --left;
      continue;
    }
    ILP_TAKE(const double error_px, error_by_poses(place));
    if (error_px <= largest_pose_error_px) ILP_TRY(mark_seen_by(one, cam_from_strip, error_px));
    return true;
  }
  return false;
}

/// Ground of another strip that no link of this keyframe leads to, where one of the keyframes just before does: the
/// chain relates this keyframe to that one.
Result<bool> PlaceMarks::mark_by_links_before(std::size_t& left) {
  const std::int64_t first = work_.keyframe.id - work_.keyframe.index;
  if (work_.pose.state != PoseState::final || !(work_.ground_distance > 0) || first <= 1) return false;
  FixedVector<std::int64_t, chained_keyframes + limits::max_links_per_keyframe> reached;
  for (const LinkRecord& link : work_.links) {
    if (link.verdict != LinkVerdict::images_only) static_cast<void>(reached.push_back(link.place_strip_id));
  }
  static_cast<void>(reached.push_back(work_.keyframe.strip_id));
  for (std::int64_t id = work_.keyframe.id - 1; id >= first && id > work_.keyframe.id - chained_keyframes; --id) {
    LinkRecord link;
    for (std::int64_t number = 0; number < limits::max_links_per_keyframe; ++number) {
      ILP_TAKE(const bool found, find(wiring_.store, link_id(id, number), link));
      if (!found) break;
      const bool known = std::find(reached.begin(), reached.end(), link.place_strip_id) != reached.end();
      if (known || link.verdict != LinkVerdict::linked || reached.size() == reached.capacity()) continue;
      static_cast<void>(reached.push_back(link.place_strip_id));
      ILP_TAKE(const bool marked, mark_by_link_of(id, link, left));
      if (marked) return true;
    }
  }
  return false;
}

Result<bool> PlaceMarks::mark_by_link_of(std::int64_t linked_id, const LinkRecord& link, std::size_t& left) {
  PoseRecord linked, place;
  ILP_TRY(measured(linked_id, linked));
  ILP_TRY(measured(link.place_id, place));
  if (linked.state != PoseState::final || place.state != PoseState::final) return false;
  const Similarity here_from_world = similarity_from(cam_from_world(pose_of(work_.pose)));
  const Similarity linked_from_here =
      compose(similarity_from(cam_from_world(pose_of(linked))), inverse(here_from_world));
  const double error_px = pose_sigmas * work_.camera.fx *
                          error_of_link_at(link, linked_from_here * Vec3(0, 0, work_.ground_distance)) /
                          work_.ground_distance;
  if (!(error_px <= largest_pose_error_px)) return false;
  const Similarity cam_from_strip =
      compose(inverse(linked_from_here), compose(similarity_of(link), similarity_from(cam_from_world(pose_of(place)))));
  NearPlaces near;
  workspace_.table.find_near(link.place_strip_id, work_.keyframe.id - 1, cam_from_strip, work_.ground_distance,
                             any_in_common, work_.camera, near);
  return mark_by_one_of(near, cam_from_strip, error_px, left);
}

Result<bool> PlaceMarks::mark_next() {
  std::size_t left = work_.marked++;
  for (const LinkRecord& link : work_.links) {
    ILP_TAKE(const bool marked, mark_by(link, left));
    if (marked) return true;
  }
  if (work_.depth.verdict != DepthVerdict::ok) return false;
  ILP_TAKE(const bool marked, mark_by_links_before(left));
  return marked ? Result<bool>(true) : mark_by_poses(left);
}

/// By one earlier keyframe.
Status PlaceMarks::mark_known_ground() {
  const bool masked = work_.mask.code.bytes != 0 && work_.mask.code.bytes <= workspace_.mask_bytes.size();
  ILP_TAKE(const bool marked, masked ? mark_next() : Result<bool>(false));
  if (marked) return {};
  work_.marked = 0;
  work_.phase = work_.mask_loaded ? Phase::cut : Phase::record;
  return {};
}

/// Takes the ground that is known out of the mask.
Status PlaceMarks::cut_mask() {
  if (take_known_slice(workspace_.known, sliver_px, border_px, workspace_.image.view(), work_.marked++,
                       work_.known_before))
    return {};
  work_.phase = Phase::record;
  work_.mask_changed = work_.known_before != 0;
  if (!work_.mask_changed) return {};
  std::size_t bytes = 0;
  ILP_TRY(encode_mask(workspace_.image.view(), workspace_.mask_bytes.data(), workspace_.mask_bytes.size(), bytes));
  work_.mask.code.bytes = static_cast<std::uint32_t>(bytes);
  work_.mask.newly_seen -= std::min(work_.mask.newly_seen, work_.known_before);
  return {};
}

}  // namespace ilp
