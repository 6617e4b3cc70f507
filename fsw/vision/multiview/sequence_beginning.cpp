#include "fsw/vision/multiview/sequence_beginning.hpp"

#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

// A pair with less median parallax (rotation removed, over the focal length), or with fewer inliers, gives too few
// points for the resection of the next keyframe. It begins only if no other pair does. The parallax is twice the least
// triangulation angle, and a tenth of the parallax at an overlap of 82 %.
constexpr double min_first_parallax_rad = 0.02;
constexpr std::uint32_t min_first_inliers = 60;

// Streams that separate the random numbers of one keyframe's searches; other parts have 1 to 3.
constexpr std::uint64_t pair_stream = 4;
constexpr std::uint64_t extend_stream = 5;
constexpr std::uint64_t other_view_stream = 6;
constexpr std::size_t none = limits::max_bundle_cameras;
constexpr std::uint64_t views_of_a_strip = limits::max_bundle_cameras;

/// A strip whose structure has not begun counts its ordinals from 0, so that they are the indices of its cameras.
Vec2 seen_at(const Track& track, std::size_t ordinal) {
  const std::size_t k = ordinal - track.first;
  return {static_cast<double>(track.x[k]), static_cast<double>(track.y[k])};
}

Vec3 centre_of(const SequenceCamera& camera) {
  return {camera.pose.centre[0], camera.pose.centre[1], camera.pose.centre[2]};
}

}  // namespace

/// Before the structure begins, a rotation is a relation as well, and so is a baseline too short to have a direction.
bool SequenceBeginning::relates(const TwoViewResult& pair) const {
  const bool without_direction =
      pair.verdict == TwoViewVerdict::ill_conditioned && !(pair.sigma_direction_rad <= largest_sigma_direction_rad);
  return pair.verdict == TwoViewVerdict::ok || pair.verdict == TwoViewVerdict::planar ||
         pair.verdict == TwoViewVerdict::too_little_parallax || without_direction;
}

/// What pairs are ranked by: less is better.
double SequenceBeginning::promise(const TwoViewResult& pair) const {
  const double error = expected_depth_error(pair, focal_px());
  const bool few_points =
      pair.inliers < min_first_inliers || pair.median_parallax_px < min_first_parallax_rad * focal_px();
  return few_points ? error + s_.params.max_first_depth_error : error;
}

Status SequenceBeginning::begin_structure() {
  RigidTransform this_from_previous;
  for (int i = 0; i < 9; ++i) this_from_previous.rotation(i / 3, i % 3) = s_.pair_rotation[i];
  for (int i = 0; i < 3; ++i) this_from_previous.translation[i] = s_.pair_translation[i];
  for (std::size_t i = 0; i < s_.matches.size(); ++i) w_.contradicts[i] = 0;
  map_corners(s_.tracks, newest(), w_.track_of_corner);
  push_camera(compose(this_from_previous, cam_from_world(s_.cameras[0].pose)));
  tracks_.extend();
  ILP_TRY(tracks_.triangulate());
  if (s_.report.new_points < min_resection_inliers) {
    s_.cameras.pop_back();
    s_.tracks.clear();
    return {};
  }
  scale_to_first_height();
  s_.first_pair.begun = true;
  return {};
}

void SequenceBeginning::gather(const TwoViewResult& pair) {
  // The attitude is known but for small errors, the place is not.
  RigidTransform camera = cam_from_world(s_.cameras.back().pose);
  camera.rotation = pair.b_from_a.rotation * camera.rotation;
  for (std::size_t i = 0; i < s_.matches.size(); ++i) w_.contradicts[i] = 0;
  map_corners(s_.tracks, newest(), w_.track_of_corner);
  push_camera(camera, false);
  tracks_.extend();
  keep_candidate(newest() - 1, newest(), pair);
  s_.first_pair.next = newest() - 1;
  s_.phase = SequencePhase::rank;
}

void SequenceBeginning::keep_candidate(std::size_t a, std::size_t b, const TwoViewResult& pair) {
  FirstPair::Candidate& best = s_.first_pair.best;
  const double error = promise(pair);
  if (!std::isfinite(error) || (best.error > 0 && best.error <= error)) return;
  best = {error, s_.seed, static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
}

/// The tracks that both cameras see; w_.match_of_view has their indices.
void SequenceBeginning::fill_pairs(std::size_t a, std::size_t b) {
  w_.pairs.clear();
  for (std::size_t i = 0; i < s_.tracks.size(); ++i) {
    const Track& track = s_.tracks[i];
    if (!sees(track, a) || !sees(track, b) || w_.pairs.full()) continue;
    const Vec2 at_a = seen_at(track, a), at_b = seen_at(track, b);
    w_.match_of_view[w_.pairs.size()] = static_cast<std::uint16_t>(i);
    (void)w_.pairs.push_back({at_a.x(), at_a.y(), at_b.x(), at_b.y(), 0});
  }
}

Status SequenceBeginning::estimate_pair(std::size_t a, std::size_t b, std::uint64_t seed, TwoViewResult& pair) {
  pair = {};
  fill_pairs(a, b);
  if (w_.pairs.size() < s_.params.two_view.min_inliers) return {};
  const RansacParams params = two_view_params(mix64(seed ^ pair_stream) ^ (views_of_a_strip * a + b));
  const Status status = estimate_two_view(w_.pairs, s_.camera, s_.camera, params, w_.two_view, w_.pair_inliers, pair);
  if (status.is(StatusCode::invalid_argument)) return status;
  if (!status.ok()) pair.verdict = TwoViewVerdict::too_few_inliers;
  return {};
}

Status SequenceBeginning::rank() {
  FirstPair& first = s_.first_pair;
  if (first.next > 0) {
    --first.next;
    TwoViewResult pair;
    ILP_TRY(estimate_pair(first.next, newest(), s_.seed, pair));
    keep_candidate(first.next, newest(), pair);
    return {};
  }
  const bool last = s_.cameras.size() == max_first_keyframes;
  if (first.best.error > 0 && (last || first.best.error <= s_.params.max_first_depth_error)) {
    s_.phase = SequencePhase::begin;
  } else {
    keep_waiting(false);
  }
  return {};
}

/// The newest keyframe joins those without a pose. If they are as many as may wait, the oldest one leaves.
void SequenceBeginning::keep_waiting(bool candidate_failed) {
  for (SequenceCamera& camera : s_.cameras) camera.posed = false;
  for (Track& track : s_.tracks) {
    track.phase = TrackPhase::open;
    track.used = observed_bits(track);
  }
  s_.first_pair.ambiguous = false;
  if (candidate_failed) s_.first_pair.best = {};
  if (s_.cameras.size() == max_first_keyframes) drop_camera(0);
  s_.corners = s_.new_corners;
  fail(SequenceVerdict::waiting);
}

/// The next camera has the attitude of the world if the first one leaves.
void SequenceBeginning::drop_camera(std::size_t index) {
  (void)s_.dropped.push_back(s_.cameras[index].keyframe_id);
  if (index == 0) {
    for (int i = 0; i < 4; ++i) s_.params.q_first[i] = s_.cameras[1].pose.q_cam_from_world[i];
  }
  s_.cameras.erase(index);
  for (Track& track : s_.tracks) {
    leave_out(track, static_cast<std::uint32_t>(index));
    if (track.count < 2) track.phase = TrackPhase::removed;
  }
  compact(s_.tracks);
  FirstPair::Candidate& best = s_.first_pair.best;
  if (best.a == index || best.b == index) best = {};
  best.a -= best.a > index ? 1 : 0;
  best.b -= best.b > index ? 1 : 0;
}

/// Over a plane, each of the other keyframes is a third view.
Status SequenceBeginning::decide_by_others(RigidTransform& b_from_a) {
  FirstPair& first = s_.first_pair;
  for (std::size_t c = 0; c < s_.cameras.size() && first.ambiguous; ++c) {
    if (c == first.best.a || c == first.best.b) continue;
    fill_pairs(first.best.b, c);
    if (w_.pairs.size() < s_.params.two_view.min_inliers) continue;
    const RansacParams params = two_view_params(mix64(first.best.seed ^ other_view_stream) ^ c);
    MotionChoice choice = MotionChoice::taken;
    ThirdViewChoice third;
    ILP_TRY(choose_motion(first, w_.pairs, s_.camera, params, w_.two_view, choice, third));
    first.ambiguous = choice == MotionChoice::open;
    if (choice == MotionChoice::rival) b_from_a = rival_camera(first, 0);
  }
  return {};
}

Status SequenceBeginning::begin_with_candidate() {
  FirstPair& first = s_.first_pair;
  const std::size_t a = first.best.a, b = first.best.b;
  TwoViewResult pair;
  ILP_TRY(estimate_pair(a, b, first.best.seed, pair));
  if (!std::isfinite(promise(pair))) {
    keep_waiting(true);
    return {};
  }
  for (std::size_t i = 0; i < w_.pairs.size(); ++i) {
    if (w_.pair_inliers[i] == 0) s_.tracks[w_.match_of_view[i]].phase = TrackPhase::removed;
  }
  compact(s_.tracks);
  RigidTransform b_from_a = pair.b_from_a;
  remember_rival(pair.planes, first);
  ILP_TRY(decide_by_others(b_from_a));
  if (first.ambiguous && s_.strip_open && s_.cameras.size() < max_first_keyframes) {
    keep_waiting(false);
    return {};
  }
  // After that many views the motion taken stands.
  if (s_.cameras.size() == max_first_keyframes) first.ambiguous = false;
  for (std::size_t i = 0; i < s_.cameras.size(); ++i) s_.cameras[i].posed = i == a || i == b;
  s_.cameras[b].pose = pose_from(compose(b_from_a, cam_from_world(s_.cameras[a].pose)));
  ILP_TRY(tracks_.triangulate());
  s_.phase = SequencePhase::extend_from_pair;
  if (s_.report.new_points < min_resection_inliers) keep_waiting(true);
  return {};
}

/// The camera without a pose that sees most points.
std::size_t SequenceBeginning::next_to_extend() {
  std::array<std::uint32_t, max_first_keyframes> points{};
  for (const Track& track : s_.tracks) {
    if (track.phase != TrackPhase::point) continue;
    for (std::size_t c = track.first; c < end_of(track); ++c) points[c] += sees(track, c) ? 1 : 0;
  }
  std::size_t most = none;
  for (std::size_t c = 0; c < s_.cameras.size(); ++c) {
    if (!s_.cameras[c].posed && (most == none || points[c] > points[most])) most = c;
  }
  return most;
}

Status SequenceBeginning::extend_from_pair() {
  const std::size_t c = next_to_extend();
  if (c == none) {
    lay_world();
    s_.phase = SequencePhase::adjust;
    return {};
  }
  w_.views.clear();
  for (std::size_t i = 0; i < s_.tracks.size(); ++i) {
    const Track& track = s_.tracks[i];
    if (track.phase != TrackPhase::point || !sees(track, c) || w_.views.full()) continue;
    const Vec2 at = seen_at(track, c);
    w_.match_of_view[w_.views.size()] = static_cast<std::uint16_t>(i);
    (void)w_.views.push_back({{track.position[0], track.position[1], track.position[2]}, at.x(), at.y()});
  }
  ResectionResult result;
  const Status status =
      resect(w_.views, s_.camera, resection_params(s_.first_pair.best.seed ^ mix64(extend_stream + c)), w_.view_inliers,
             result);
  const bool verdict = status.is(StatusCode::too_few_matches) || status.is(StatusCode::no_model);
  if (!status.ok() && !verdict) return status;
  const bool is_newest = c + 1 == s_.cameras.size();
  if (is_newest) {
    s_.report.known_points = static_cast<std::uint32_t>(w_.views.size());
    s_.report.resection_inliers = result.inliers;
  }
  // Chance would not agree with half of the points.
  if (!status.ok() || 2 * std::size_t{result.inliers} < w_.views.size()) {
    // The next keyframe is matched with the newest one, so it must stay.
    if (is_newest && s_.strip_open) {
      keep_waiting(true);
    } else {
      drop_camera(c);
    }
    return {};
  }
  s_.cameras[c].pose = pose_from(result.cam_from_world);
  s_.cameras[c].posed = true;
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    if (w_.view_inliers[v] != 0) continue;
    Track& track = s_.tracks[w_.match_of_view[v]];
    track.used = static_cast<std::uint16_t>(track.used & ~(1U << (c - track.first)));
    if (c + 1 == end_of(track)) track.growing = false;
  }
  ILP_TRY(tracks_.triangulate());
  s_.phase = SequencePhase::extend_from_pair;
  return {};
}

/// Moves the structure to the strip's world: its first camera to the origin, with its attitude there. The unit is the
/// distance to the first camera that is as far from it as half of the baseline of the best pair.
void SequenceBeginning::lay_world() {
  RigidTransform down;
  down.rotation = rotation_from_quaternion(s_.params.q_first);
  const RigidTransform world_from_now = compose(inverse(down), cam_from_world(s_.cameras[0].pose));
  const RigidTransform now_from_world = inverse(world_from_now);
  const FirstPair::Candidate& best = s_.first_pair.best;
  const double enough = 0.5 * (centre_of(s_.cameras[best.b]) - centre_of(s_.cameras[best.a])).norm();
  const Vec3 origin = centre_of(s_.cameras[0]);
  std::uint32_t far = 1;
  while (far + 1U < s_.cameras.size() && (centre_of(s_.cameras[far]) - origin).norm() < enough) ++far;
  const double scale = 1 / (centre_of(s_.cameras[far]) - origin).norm();
  for (SequenceCamera& camera : s_.cameras) {
    camera.pose = pose_from(compose(cam_from_world(camera.pose), now_from_world));
    for (double& x : camera.pose.centre) x *= scale;
  }
  for (Track& track : s_.tracks) {
    if (track.phase != TrackPhase::point) continue;
    const Vec3 position = scale * (world_from_now * Vec3(track.position[0], track.position[1], track.position[2]));
    for (int k = 0; k < 3; ++k) track.position[k] = position[k];
  }
  scale_to_first_height();
  s_.first_pair.scale_camera = far;
  s_.first_pair.begun = true;
}

}  // namespace ilp
