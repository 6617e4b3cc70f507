#include "fsw/places/place_links.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/rng.hpp"
#include "fsw/places/place_blobs.hpp"
#include "fsw/vision/geometry/camera.hpp"

namespace ilp {
namespace {

/// Where the chain is close, more links hardly make the poses better.
constexpr std::size_t enough_links = 3;
/// A distance of places, in half sides of the image.
constexpr double much_in_common = 1;
/// 99.9 % of the squared errors of three coordinates lie below 16.3. The pose errors are stated along the strip only,
/// so that three times the sigma is allowed.
constexpr double largest_misfit = 3 * 3 * 16.3;
/// Patches are registered to a tenth of a pixel; the depths of their cells add their relief.
constexpr double registered_threshold_px = 2.5, registered_sigma_px = 0.3;

/// False outside the image that the units can name.
bool in_link_units(float px, std::uint16_t& units) {
  const double scaled = std::floor(static_cast<double>(px) * link_points_per_px + 0.5);
  if (!(scaled >= 0 && scaled <= 65535)) return false;
  units = static_cast<std::uint16_t>(scaled);
  return true;
}

}  // namespace

void PlaceLinks::add_candidate(std::size_t slot) {
  const auto number = static_cast<std::uint16_t>(slot);
  if (workspace_.table.at(slot).keyframe_id == 0) return;
  if (std::find(work_.candidates.begin(), work_.candidates.end(), number) == work_.candidates.end()) {
    static_cast<void>(work_.candidates.push_back(number));
  }
}

/// Of the places, which stand in the order of what they promise, the first.
template <typename Places>
void PlaceLinks::add_candidates(const Places& places) {
  const std::size_t most = weakly_connected() ? limits::max_place_candidates : limits::place_candidates;
  for (std::size_t i = 0; i < places.size() && i < most; ++i) add_candidate(places[i].slot);
}

Status PlaceLinks::search() {
  if (weakly_connected()) {
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
    TieRecord tie;
    ILP_TAKE(const bool tied, find(wiring_.store, work_.keyframe.strip_id, tie));
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
Status PlaceLinks::compare() {
  const RememberedPlace& place = workspace_.table.at(work_.candidates[work_.compared++]);
  PlaceRecord record;
  ILP_TAKE(const bool found, find(wiring_.store, place.keyframe_id, record));
  ILP_TAKE(const bool valid, found ? recall_.load_features(record) : Result<bool>(false));
  if (valid) ILP_TRY(link_with(place, record));
  const std::size_t enough = weakly_connected() ? work_.links.capacity() : enough_links;
  if (work_.compared == work_.candidates.size() || work_.links.size() >= enough)
    work_.phase = (workspace_.features.empty() ? Phase::record : Phase::narrow);
  return {};
}

/// Inside a strip: whether the link agrees with the poses, by where they put the ground in the middle of the image.
void PlaceLinks::judge(LinkRecord& link, const PoseRecord& place) {
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
Status PlaceLinks::register_patches(const PlaceRecord& place, LinkPoints& points) {
  points.clear();
  const std::size_t count =
      std::min<std::size_t>(place.patches.bytes / sizeof(PlacePatch), workspace_.older_patches.capacity());
  static_cast<void>(workspace_.older_patches.resize(count));
  ILP_TAKE(const bool whole, found_by(read_blob<PlaceRecord>(wiring_.store, "patches", place.id, 0,
                                                             writable_octets(workspace_.older_patches.data(), count))));
  if (!whole) return {};
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

void PlaceLinks::match_features() {
  workspace_.matches.clear();
  for (const PlacePair& pair : workspace_.match.pairs) {
    const PlaceFeature& a = workspace_.older[pair.older];
    const PlaceFeature& b = workspace_.features[pair.newer];
    add_match(a.x, a.y, workspace_.older_depths[pair.older], b.x, b.y);
  }
}

void PlaceLinks::match_patches() {
  workspace_.matches.clear();
  for (const PatchSighting& seen : workspace_.sightings) {
    const PlacePatch& patch = workspace_.older_patches[seen.patch];
    add_match(patch.x, patch.y, patch.inverse_depth, seen.x, seen.y);
  }
}

void PlaceLinks::add_match(float older_x, float older_y, float older_depth, float x, float y) {
  const Vec2 from = ideal_from_pixel(work_.camera, Vec2(static_cast<double>(older_x), static_cast<double>(older_y)));
  const Vec2 to = ideal_from_pixel(work_.camera, Vec2(static_cast<double>(x), static_cast<double>(y)));
  static_cast<void>(
      workspace_.matches.push_back({from.x(), from.y(), static_cast<double>(older_depth), to.x(), to.y(),
                                    static_cast<double>(depth_at(workspace_.depths, workspace_.seen, x, y))}));
}

/// By registered patches, or by features where too few patches agree.
Status PlaceLinks::relate(std::uint64_t link_id, LinkGeometry& geometry) {
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

Status PlaceLinks::link_with(const RememberedPlace& place, const PlaceRecord& record) {
  ILP_TRY(verify_place(Features(workspace_.older.data(), workspace_.older.size()),
                       Features(workspace_.features.data(), workspace_.features.size()), least_place_evidence,
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

}  // namespace ilp
