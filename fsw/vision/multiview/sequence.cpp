#include "fsw/vision/multiview/sequence.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/median.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "fsw/vision/twoview/solvers/triangulation.hpp"

namespace ilp {
namespace {

// Streams that separate the random numbers of one keyframe's searches.
constexpr std::uint64_t two_view_stream = 1;
constexpr std::uint64_t resection_stream = 2;
constexpr std::uint64_t third_view_stream = 3;
// Two estimates of one rotation farther apart than this are two different solutions, whose baselines do not compare.
constexpr double same_rotation_rad = 0.05;

Vec2 ideal_of(const CameraModel& camera, const Corner& corner) {
  return ideal_from_pixel(camera, Vec2(corner.x, corner.y));
}

Vec3 position_of(const Track& track) {
  return {track.position[0], track.position[1], track.position[2]};
}

void set_position(Track& track, const Vec3& x) {
  for (int k = 0; k < 3; ++k) track.position[k] = x[k];
}

/// Distance in px between the projection of `x` and an observation; huge behind the camera.
double reprojection_error(const CameraModel& camera, const RigidTransform& pose, const Vec3& x, double u, double v) {
  const Vec3 p = pose * x;
  if (!(p.z() > 0)) return 1e150;
  const double du = camera.fx * (p.x() / p.z()) + camera.cx - u;
  const double dv = camera.fy * (p.y() / p.z()) + camera.cy - v;
  return std::sqrt(du * du + dv * dv);
}

struct CameraTransforms {
  explicit CameraTransforms(const SequenceState& state) {
    for (std::size_t i = 0; i < state.cameras.size(); ++i) at[i] = cam_from_world(state.cameras[i].pose);
  }
  std::array<RigidTransform, limits::max_bundle_cameras> at;
};

Status check(const SequenceParams& p) {
  const bool good = p.window_keyframes >= 2 && p.window_keyframes <= limits::max_window_keyframes &&
                    p.resection_threshold_px > 0 && p.resection_max_trials > 0 && p.min_resection_inliers >= 4 &&
                    p.max_reprojection_px > 0 && p.min_triangulation_angle_rad > 0 && p.robust_px >= 0 &&
                    p.loss <= BundleLoss::cauchy && p.bundle_tolerance >= 0 && p.first_height >= 0 &&
                    p.max_first_depth_error > 0 && p.min_first_parallax_rad >= 0 && p.max_scale_step > 1 &&
                    p.max_tilt_step_rad > 0 && p.max_step_footprints > 0;
  return good ? Status{} : out_of_range(Argument::sequence_parameters);
}

Status check(const Matches& matches, std::size_t corners_a, std::size_t corners_b) {
  std::bitset<limits::max_corners> seen_a;
  std::bitset<limits::max_corners> seen_b;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Match& m = matches[i];
    if (m.a >= corners_a || m.b >= corners_b || seen_a[m.a] || seen_b[m.b]) return out_of_range(Argument::match, i);
    seen_a[m.a] = true;
    seen_b[m.b] = true;
  }
  return {};
}

PairReport report_of(const TwoViewResult& result) {
  return {result.verdict,
          result.inliers,
          result.gric_e,
          result.gric_h,
          result.median_parallax_px,
          result.rms_px,
          result.sigma_rotation_rad,
          result.sigma_direction_rad};
}

bool usable(TwoViewVerdict verdict) {
  return verdict == TwoViewVerdict::ok || verdict == TwoViewVerdict::planar;
}

/// Depth in a of the point on two rays when the baseline |t| is 1; zero when the rays are parallel.
double depth_from_pair(const RigidTransform& b_from_a, const Vec2& a, const Vec2& b) {
  const Vec3 ray_a = b_from_a.rotation * Vec3(a.x(), a.y(), 1);
  const Vec3 ray_b(b.x(), b.y(), 1);
  const Vec3 across = cross_matrix(ray_a) * ray_b;
  const Vec3 moved = cross_matrix(b_from_a.translation) * ray_b;
  const double squared = across.squaredNorm();
  return squared > 0 ? -moved.dot(across) / squared : 0;
}

}  // namespace

void refine_corners(const Matches& matches, Corners& corners_b) {
  for (const Match& m : matches) {
    if (m.b >= corners_b.size()) continue;
    corners_b[m.b].x = m.xb;
    corners_b[m.b].y = m.yb;
  }
}

Status Sequence::begin_strip(const CameraModel& camera, const SequenceParams& params) {
  ILP_TRY(validate(camera));
  ILP_TRY(check(params));
  s_.camera = camera;
  s_.params = params;
  s_.strip_open = true;
  s_.phase = SequencePhase::idle;
  s_.adjusting = false;
  s_.oldest = s_.final_count = s_.taken_count = s_.point_cursor = s_.back = 0;
  s_.cameras.clear();
  s_.first_pair = {};
  s_.dropped.clear();
  begin_covariance(s_.covariance);
  s_.tracks.clear();
  s_.corners.clear();
  s_.new_corners.clear();
  s_.matches.clear();
  s_.related.clear();
  s_.bundle = {};
  s_.report = {};
  return {};
}

Status Sequence::begin_keyframe_on(std::uint32_t back, std::int64_t keyframe_id, const Corners& corners,
                                   const Matches& matches, std::uint64_t seed) {
  if (!s_.strip_open || s_.phase != SequencePhase::idle || !can_go_back_to(back)) return StatusCode::not_ready;
  ILP_ASSERT(s_.taken_count == s_.final_count, s_.final_count - s_.taken_count);
  for (std::size_t i = s_.point_cursor; i < s_.tracks.size(); ++i) {
    ILP_ASSERT(s_.tracks[i].phase != TrackPhase::final_point, i);
  }
  compact(s_.tracks);
  s_.back = back;
  // The first keyframe has no previous one: matches are meaningless and ignored.
  s_.matches.clear();
  if (!s_.cameras.empty()) {
    ILP_TRY(check(matches, back > 0 ? map_base() : s_.corners.size(), corners.size()));
    s_.matches = matches;
  }
  s_.point_cursor = 0;
  s_.new_corners = corners;
  refine_corners(s_.matches, s_.new_corners);
  for (std::size_t i = 0; i < s_.new_corners.size(); ++i) {
    if (!std::isfinite(s_.new_corners[i].x) || !std::isfinite(s_.new_corners[i].y)) {
      return out_of_range(Argument::corner, i);
    }
  }
  s_.report = {};
  s_.dropped.clear();
  s_.keyframe_id = keyframe_id;
  s_.seed = seed;
  s_.report.matches = static_cast<std::uint32_t>(s_.matches.size());
  s_.phase = SequencePhase::relate;
  return {};
}

Status Sequence::step(bool& pending) {
  Status status;
  switch (s_.phase) {
    case SequencePhase::idle:
      break;
    case SequencePhase::relate:
      status = relate();
      break;
    case SequencePhase::rank:
      status = rank();
      break;
    case SequencePhase::begin:
      status = begin_with_candidate();
      break;
    case SequencePhase::surround:
      status = surround();
      break;
    case SequencePhase::decide:
      status = decide();
      break;
    case SequencePhase::resect:
      status = resect_camera();
      break;
    case SequencePhase::triangulate:
      status = triangulate_tracks();
      break;
    case SequencePhase::adjust:
      status = adjust(s_.params.max_bundle_iterations, SequencePhase::state_errors, SequencePhase::prune);
      break;
    case SequencePhase::prune:
      status = prune();
      break;
    case SequencePhase::readjust:
      status = adjust(s_.params.max_readjust_iterations, SequencePhase::restate_errors, SequencePhase::conclude);
      break;
    case SequencePhase::conclude:
      status = conclude();
      break;
    case SequencePhase::relating:
      status = go_on_relating();
      break;
    case SequencePhase::state_errors:
      state_errors(s_.params.max_bundle_iterations, SequencePhase::prune);
      break;
    case SequencePhase::restate_errors:
      state_errors(s_.params.max_readjust_iterations, SequencePhase::conclude);
      break;
  }
  pending = s_.phase != SequencePhase::idle;
  return status;
}

Status Sequence::add_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                              std::uint64_t seed, SequenceReport& report) {
  ILP_TRY(begin_keyframe(keyframe_id, corners, matches_to_previous, seed));
  bool pending = true;
  while (pending) ILP_TRY(step(pending));  // bound: the steps of one keyframe
  report = s_.report;
  return {};
}

void Sequence::fail(SequenceVerdict verdict) {
  s_.report.verdict = verdict;
  s_.phase = SequencePhase::idle;
}

void Sequence::fill_pairs() {
  if (s_.back > 0) (void)map_base();
  w_.pairs.clear();
  for (const Match& m : s_.matches) {
    const Vec2 a = seen_from_base(m);
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    (void)w_.pairs.push_back({a.x(), a.y(), b.x(), b.y(), m.score});
  }
}

RansacParams Sequence::two_view_params(std::uint64_t seed) const {
  RansacParams params = s_.params.two_view;
  params.seed = mix64(params.seed ^ mix64(seed ^ two_view_stream));
  return params;
}

Status Sequence::relate() {
  if (s_.cameras.empty()) {
    RigidTransform down;
    down.rotation = rotation_from_quaternion(s_.params.q_first);
    push_camera(down);
    s_.corners = s_.new_corners;
    fail(SequenceVerdict::waiting);
    return {};
  }
  if (s_.matches.size() < s_.params.two_view.min_inliers) {
    fail(SequenceVerdict::too_few_matches);
    return {};
  }
  fill_pairs();
  TwoViewResult pair;
  const Status status =
      begin_two_view(w_.pairs, s_.camera, s_.camera, two_view_params(s_.seed), w_.two_view, w_.pair_inliers, pair);
  if (status.is(StatusCode::invalid_argument)) {
    fail(SequenceVerdict::two_view_failed);
    return status;
  }
  if (!status.ok()) {
    pair.verdict = TwoViewVerdict::too_few_inliers;
    return take_relation(pair);
  }
  s_.phase = SequencePhase::relating;
  return {};
}

Status Sequence::go_on_relating() {
  TwoViewResult pair;
  bool more = false;
  two_view_slice(s_.camera, s_.camera, two_view_params(s_.seed), w_.two_view, w_.pair_inliers, pair, more);
  return more ? Status{} : take_relation(pair);
}

Status Sequence::take_relation(const TwoViewResult& pair) {
  s_.report.two_view = report_of(pair);
  for (int i = 0; i < 9; ++i) s_.pair_rotation[i] = pair.b_from_a.rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) s_.pair_translation[i] = pair.b_from_a.translation[i];

  const bool begun = s_.first_pair.begun;
  const bool related = begun ? usable(pair.verdict) : relates(pair);
  const bool trusted = related && w_.pair_inliers.size() == s_.matches.size();
  s_.related.clear();
  for (std::size_t i = 0; i < s_.matches.size(); ++i) {
    // Without a relation every match may be right, and the resection finds the outliers.
    (void)s_.related.push_back(trusted ? w_.pair_inliers[i] : std::uint8_t{1});
  }
  if (begun) {
    s_.phase = s_.first_pair.ambiguous ? SequencePhase::decide : SequencePhase::resect;
    return {};
  }
  if (!trusted) {
    fail(SequenceVerdict::two_view_failed);
    return {};
  }
  if (s_.cameras.size() > 1 || promise(pair) > s_.params.max_first_depth_error) {
    gather(pair);
    return {};
  }
  ILP_TRY(begin_structure());
  if (s_.first_pair.begun) {
    remember_rival(pair.planes, s_.first_pair);
  } else {
    gather(pair);
  }
  return {};
}

Status Sequence::begin_structure() {
  RigidTransform this_from_previous;
  for (int i = 0; i < 9; ++i) this_from_previous.rotation(i / 3, i % 3) = s_.pair_rotation[i];
  for (int i = 0; i < 3; ++i) this_from_previous.translation[i] = s_.pair_translation[i];
  for (std::size_t i = 0; i < s_.matches.size(); ++i) w_.contradicts[i] = 0;
  map_corners(s_.tracks, newest(), w_.track_of_corner);
  push_camera(compose(this_from_previous, cam_from_world(s_.cameras[0].pose)));
  extend_tracks();
  ILP_TRY(triangulate_tracks());
  if (s_.report.new_points < s_.params.min_resection_inliers) {
    s_.cameras.pop_back();
    s_.tracks.clear();
    return {};
  }
  scale_to_first_height();
  s_.first_pair.begun = true;
  return {};
}

void Sequence::scale_to_first_height() {
  if (!(s_.params.first_height > 0)) return;
  std::size_t count = 0;
  for (const Track& track : s_.tracks) {
    // At most max_matches tracks were begun. The first camera looks down: depth is minus z.
    if (track.phase == TrackPhase::point) w_.ratios[count++] = -track.position[2];
  }
  if (count == 0) return;
  const double scale = s_.params.first_height / upper_median(std::span(w_.ratios).first(count));
  for (std::size_t i = 1; i < s_.cameras.size(); ++i) {
    for (double& x : s_.cameras[i].pose.centre) x *= scale;
  }
  for (Track& track : s_.tracks) {
    for (double& x : track.position) x *= scale;
  }
}

Status Sequence::decide() {
  fill_pairs();
  RansacParams params = s_.params.two_view;
  params.seed = mix64(params.seed ^ mix64(s_.seed ^ third_view_stream));
  MotionChoice choice = MotionChoice::taken;
  ThirdViewChoice third;
  ILP_TRY(choose_motion(s_.first_pair, w_.pairs, s_.camera, params, w_.two_view, choice, third));
  // Only once: if the whole track keeps to the line of the first step, no view ever decides.
  if (choice == MotionChoice::open && s_.first_pair.undecided == 0) {
    // In one slice, because `third` is no part of the state.
    ILP_TRY(resect_camera());
    if (s_.phase == SequencePhase::triangulate) keep_open(third, s_.first_pair);
    return {};
  }
  s_.first_pair.ambiguous = false;
  if (choice == MotionChoice::rival) ILP_TRY(take_rival_motion());
  s_.phase = SequencePhase::resect;
  return {};
}

/// Restarts the structure of two or three cameras. Outliers of the motion taken stay excluded.
Status Sequence::take_rival_motion() {
  for (std::size_t i = 1; i < s_.cameras.size(); ++i) {
    s_.cameras[i].pose = pose_from(compose(rival_camera(s_.first_pair, i - 1), cam_from_world(s_.cameras[0].pose)));
  }
  for (Track& track : s_.tracks) {
    if (track.phase == TrackPhase::removed) continue;
    track.phase = TrackPhase::open;
    track.used = observed_bits(track);
    track.growing = end_of(track) == newest() + 1;
  }
  ILP_TRY(triangulate_tracks());
  scale_to_first_height();
  return {};
}

void Sequence::collect_known_points() {
  w_.views.clear();
  for (std::size_t i = 0; i < s_.matches.size(); ++i) {
    w_.contradicts[i] = 0;
    const Match& m = s_.matches[i];
    const std::uint16_t t = w_.track_of_corner[m.a];
    if (s_.related[i] == 0 || t == no_track || s_.tracks[t].phase != TrackPhase::point) continue;
    const Track& track = s_.tracks[t];
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    w_.match_of_view[w_.views.size()] = static_cast<std::uint16_t>(i);
    (void)w_.views.push_back({{track.position[0], track.position[1], track.position[2]}, b.x(), b.y()});
  }
}

ResectionParams Sequence::resection_params(std::uint64_t seed) const {
  ResectionParams params;
  params.threshold_px = s_.params.resection_threshold_px;
  params.max_trials = s_.params.resection_max_trials;
  params.min_inliers = s_.params.min_resection_inliers;
  params.robust_px = s_.params.robust_px;
  params.seed = mix64(seed);
  return params;
}

Status Sequence::resect_camera() {
  (void)map_base();
  collect_known_points();
  s_.report.known_points = static_cast<std::uint32_t>(w_.views.size());
  ResectionResult result;
  const Status status =
      resect(w_.views, s_.camera, resection_params(s_.seed ^ resection_stream), w_.view_inliers, result);
  s_.report.resection_inliers = result.inliers;
  const bool few = s_.back > 0 && result.inliers < s_.params.min_older_inliers;
  if (!status.ok() || few) {
    fail(SequenceVerdict::resection_failed);
    const bool verdict = status.ok() || status.is(StatusCode::too_few_matches) || status.is(StatusCode::no_model);
    return verdict ? Status{} : status;
  }
  if (!plausible(result.cam_from_world)) {
    fail(SequenceVerdict::implausible);
    return {};
  }
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    if (w_.view_inliers[v] == 0) w_.contradicts[w_.match_of_view[v]] = 1;
  }
  push_camera(result.cam_from_world);
  extend_tracks();
  s_.phase = SequencePhase::triangulate;
  return {};
}

bool Sequence::plausible(const RigidTransform& pose) {
  const RigidTransform previous = cam_from_world(s_.cameras[base_index()].pose);
  const RigidTransform step = compose(pose, inverse(previous));
  if (det_acos(step.rotation(2, 2)) > s_.params.max_tilt_step_rad) return false;

  const double baseline = step.translation.norm();
  std::size_t count = 0;
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    const double* x = w_.views[v].position;
    if (w_.view_inliers[v] != 0) w_.ratios[count++] = (previous * Vec3(x[0], x[1], x[2])).z();
  }
  const double depth = upper_median(std::span(w_.ratios).first(count));
  const double footprint = depth * std::max(s_.camera.width / s_.camera.fx, s_.camera.height / s_.camera.fy);
  if (!(baseline <= s_.params.max_step_footprints * footprint)) return false;

  RigidTransform pair;
  for (int i = 0; i < 9; ++i) pair.rotation(i / 3, i % 3) = s_.pair_rotation[i];
  for (int i = 0; i < 3; ++i) pair.translation[i] = s_.pair_translation[i];
  if (!usable(s_.report.two_view.verdict) ||
      rotation_angle(step.rotation * pair.rotation.transpose()) > same_rotation_rad) {
    return true;
  }
  count = 0;
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    if (w_.view_inliers[v] == 0) continue;
    const PointView& view = w_.views[v];
    const Vec3 x = previous * Vec3(view.position[0], view.position[1], view.position[2]);
    const double unit_depth = depth_from_pair(pair, Vec2(x.x() / x.z(), x.y() / x.z()),
                                              normalised_from_ideal(s_.camera, Vec2(view.x, view.y)));
    if (unit_depth > 0) w_.ratios[count++] = x.z() / unit_depth;
  }
  if (count < s_.params.min_resection_inliers || !(baseline > 0)) return true;
  s_.report.scale_step = upper_median(std::span(w_.ratios).first(count)) / baseline;
  return s_.report.scale_step <= s_.params.max_scale_step && s_.report.scale_step * s_.params.max_scale_step >= 1;
}

void Sequence::push_camera(const RigidTransform& pose, bool posed) {
  const std::size_t keep =
      std::min<std::size_t>(limits::max_bundle_cameras, s_.params.window_keyframes + limits::max_fixed_keyframes);
  if (s_.cameras.size() == keep) {
    for (std::size_t i = 1; i < keep; ++i) s_.cameras[i - 1] = s_.cameras[i];
    s_.cameras.pop_back();
    ++s_.oldest;
    drop_oldest_camera(s_.covariance);
    for (Track& track : s_.tracks) s_.report.shortened_tracks += shorten(track, s_.oldest) ? 1 : 0;
  }
  SequenceCamera camera;
  camera.keyframe_id = s_.keyframe_id;
  camera.pose = pose_from(pose);
  camera.posed = posed;
  (void)s_.cameras.push_back(camera);  // there is room: keep is within the capacity
}

void Sequence::extend_tracks() {
  const std::uint32_t now = newest();
  std::size_t begun = 0;
  for (std::size_t i = 0; i < s_.matches.size(); ++i) {
    const Match& m = s_.matches[i];
    if (s_.related[i] == 0 || w_.contradicts[i] != 0) continue;
    const std::uint16_t t = w_.track_of_corner[m.a];
    if (t == no_track) {
      w_.match_of_view[begun++] = static_cast<std::uint16_t>(i);
      continue;
    }
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    miss_until(s_.tracks[t], now);
    extend(s_.tracks[t], m.b, b.x(), b.y());
  }
  for (Track& track : s_.tracks) {
    if (end_of(track) == now + 1) continue;
    track.growing = false;
    if (track.phase == TrackPhase::open && s_.first_pair.begun) track.phase = TrackPhase::removed;
  }
  compact(s_.tracks);
  if (Tracks::capacity() - s_.tracks.size() < begun) s_.report.evicted_tracks = make_room(s_.tracks, begun);
  for (std::size_t n = 0; n < begun; ++n) {
    const Match& m = s_.matches[w_.match_of_view[n]];
    const Vec2 a = ideal_of(s_.camera, s_.corners[m.a]);
    const Vec2 b = ideal_of(s_.camera, s_.new_corners[m.b]);
    Track track = begin_track(now - 1, m.a, a.x(), a.y());
    extend(track, m.b, b.x(), b.y());
    if (!s_.tracks.push_back(track)) ++s_.report.refused_tracks;
  }
}

Status Sequence::triangulate_tracks() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (track.phase != TrackPhase::open || track.count < 2) continue;
    std::array<RayView, limits::max_track_length> views;
    std::uint32_t count = 0;
    for (std::uint32_t k = 0; k < track.count; ++k) {
      const std::size_t camera = track.first + k - s_.oldest;
      if (!s_.cameras[camera].posed || !sees(track, track.first + k)) continue;
      views[count].normalised = normalised_from_ideal(s_.camera, Vec2(track.x[k], track.y[k]));
      views[count].cam_from_world = cameras.at[camera];
      ++count;
    }
    if (count < 2) continue;
    TriangulatedPoint point;
    const Status status = triangulate(views.data(), count, point);
    // Rays that are still too parallel wait for a wider baseline; rays that do not meet come from a wrong match.
    if (!status.ok() || point.angle_rad < s_.params.min_triangulation_angle_rad) continue;
    if (!point.in_front || point.max_error * focal_px() > s_.params.max_reprojection_px) {
      track.phase = TrackPhase::removed;
      continue;
    }
    set_position(track, point.position);
    track.phase = TrackPhase::point;
    ++s_.report.new_points;
  }
  compact(s_.tracks);
  s_.phase = SequencePhase::adjust;
  return {};
}

Status Sequence::prune() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (track.phase != TrackPhase::point) continue;
    for (std::uint32_t k = 0; k < track.count; ++k) {
      if (!uses(track, k)) continue;
      const RigidTransform& pose = cameras.at[track.first + k - s_.oldest];
      if (reprojection_error(s_.camera, pose, position_of(track), track.x[k], track.y[k]) <=
          s_.params.max_reprojection_px) {
        continue;
      }
      track.used = static_cast<std::uint16_t>(track.used & ~(1U << k));
      ++s_.report.dropped_observations;
      // If the last match was wrong, its corner belongs to another point.
      if (k + 1U == track.count) track.growing = false;
    }
    if (used_count(track) < 2) {
      track.phase = TrackPhase::removed;
      ++s_.report.lost_points;
    }
  }
  compact(s_.tracks);
  const bool again = s_.report.dropped_observations > 0 && s_.params.max_readjust_iterations > 0;
  s_.phase = again ? SequencePhase::readjust : SequencePhase::conclude;
  return {};
}

void Sequence::finish_tracks() {
  const CameraTransforms cameras(s_);
  for (Track& track : s_.tracks) {
    if (end_of(track) > s_.final_count || track.phase == TrackPhase::removed) continue;
    track.growing = false;
    bool good = track.phase == TrackPhase::point && used_count(track) >= 2;
    for (std::uint32_t k = 0; good && k < track.count; ++k) {
      const RigidTransform& pose = cameras.at[track.first + k - s_.oldest];
      good = !uses(track, k) || reprojection_error(s_.camera, pose, position_of(track), track.x[k], track.y[k]) <=
                                    s_.params.max_reprojection_px;
    }
    if (track.phase == TrackPhase::point && !good) ++s_.report.lost_points;
    track.phase = good ? TrackPhase::final_point : TrackPhase::removed;
  }
  s_.point_cursor = 0;
}

Status Sequence::conclude() {
  const std::uint32_t end = newest() + 1;
  for (const Track& track : s_.tracks) {
    if (track.phase == TrackPhase::point && end_of(track) == end && uses(track, track.count - 1U)) ++s_.report.points;
  }
  const std::uint32_t window = s_.params.window_keyframes;
  // Nothing is final while the first motion is open.
  if (end > window && !s_.first_pair.ambiguous) s_.final_count = end - window;
  for (std::size_t i = 0; i < s_.cameras.size(); ++i) {
    if (s_.oldest + i < s_.final_count) s_.cameras[i].final_pose = true;
  }
  finish_tracks();
  s_.corners = s_.new_corners;
  s_.report.verdict = SequenceVerdict::ok;
  s_.phase = SequencePhase::idle;
  return {};
}

Status Sequence::flush() {
  if (s_.phase != SequencePhase::idle) return StatusCode::not_ready;
  s_.strip_open = false;
  if (s_.cameras.empty()) return {};
  s_.final_count = newest() + 1;
  for (SequenceCamera& camera : s_.cameras) camera.final_pose = true;
  finish_tracks();
  return {};
}

bool Sequence::take_final_camera(SequenceCamera& camera) {
  if (s_.taken_count >= s_.final_count) return false;
  const std::size_t index = s_.taken_count - s_.oldest;
  camera = s_.cameras[index];
  const double factor = s_.params.error_factor * s_.params.error_factor;
  covariance_of_camera(s_.covariance, index, camera.covariance);
  for (double& x : camera.covariance) x *= factor;
  if (index > 0) {
    covariance_of_step(s_.covariance, index, cam_from_world(s_.cameras[index - 1].pose), cam_from_world(camera.pose),
                       camera.step_covariance);
    for (double& x : camera.step_covariance) x *= factor;
  }
  ++s_.taken_count;
  return true;
}

bool Sequence::take_final_point(FinalPoint& point) {
  for (; s_.point_cursor < s_.tracks.size(); ++s_.point_cursor) {
    Track& track = s_.tracks[s_.point_cursor];
    if (track.phase != TrackPhase::final_point) continue;
    point = {};
    double sum = 0;
    for (int k = 0; k < 3; ++k) point.position[k] = track.position[k];
    for (std::uint32_t k = 0; k < track.count; ++k) {
      if (!uses(track, k)) continue;
      const SequenceCamera& camera = s_.cameras[track.first + k - s_.oldest];
      const double error =
          reprojection_error(s_.camera, cam_from_world(camera.pose), position_of(track), track.x[k], track.y[k]);
      sum += error * error;
      (void)point.observations.push_back({camera.keyframe_id, track.x[k], track.y[k]});
    }
    point.error_px = static_cast<float>(std::sqrt(sum / static_cast<double>(point.observations.size())));
    track.phase = TrackPhase::removed;
    ++s_.point_cursor;
    return true;
  }
  return false;
}

}  // namespace ilp
