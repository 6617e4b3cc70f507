#include "fsw/vision/multiview/sequence_relation.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/base/median.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

// An older keyframe than the newest is one more chance for a false relation, and a pose by few points is weak.
constexpr std::uint32_t min_older_inliers = 40;
// Of scale_step and its inverse: beyond it the pose is implausible.
constexpr double max_scale_step = 1.5;

// Streams that separate the random numbers of one keyframe's searches; other parts have 1 and 4 to 6.
constexpr std::uint64_t resection_stream = 2;
constexpr std::uint64_t third_view_stream = 3;
// Two estimates of one rotation farther apart than this are two different solutions, whose baselines do not compare.
constexpr double same_rotation_rad = 0.05;
// Of the known points, where a rotation explains the pair.
constexpr double min_share_at_rest = 0.75;

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

Status SequenceRelation::relate() {
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
  tracks_.fill_pairs();
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

Status SequenceRelation::go_on_relating() {
  TwoViewResult pair;
  if (two_view_slice(s_.camera, s_.camera, two_view_params(s_.seed), w_.two_view, w_.pair_inliers, pair)) return {};
  return take_relation(pair);
}

Status SequenceRelation::take_relation(const TwoViewResult& pair) {
  s_.report.two_view = report_of(pair);
  for (int i = 0; i < 9; ++i) s_.pair_rotation[i] = pair.b_from_a.rotation(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) s_.pair_translation[i] = pair.b_from_a.translation[i];

  const bool begun = s_.first_pair.begun;
  const bool related = begun ? usable(pair.verdict) : beginning_.relates(pair);
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
  if (s_.cameras.size() > 1 || beginning_.promise(pair) > s_.params.max_first_depth_error) {
    beginning_.gather(pair);
    return {};
  }
  ILP_TRY(beginning_.begin_structure());
  if (s_.first_pair.begun) {
    remember_rival(pair.planes, s_.first_pair);
  } else {
    beginning_.gather(pair);
  }
  return {};
}

Status SequenceRelation::decide() {
  tracks_.fill_pairs();
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
Status SequenceRelation::take_rival_motion() {
  for (std::size_t i = 1; i < s_.cameras.size(); ++i) {
    s_.cameras[i].pose = pose_from(compose(rival_camera(s_.first_pair, i - 1), cam_from_world(s_.cameras[0].pose)));
  }
  for (Track& track : s_.tracks) {
    if (track.phase == TrackPhase::removed) continue;
    track.phase = TrackPhase::open;
    track.used = observed_bits(track);
    track.growing = end_of(track) == newest() + 1;
  }
  ILP_TRY(tracks_.triangulate());
  scale_to_first_height();
  return {};
}

Status SequenceRelation::resect_camera() {
  (void)tracks_.map_base();
  tracks_.collect_known_points();
  s_.report.known_points = static_cast<std::uint32_t>(w_.views.size());
  ResectionResult result;
  const Status status =
      resect(w_.views, s_.camera, resection_params(s_.seed ^ resection_stream), w_.view_inliers, result);
  s_.report.resection_inliers = result.inliers;
  const bool few = s_.back > 0 && result.inliers < min_older_inliers;
  if (!status.ok() || few) {
    fail(SequenceVerdict::resection_failed);
    const bool verdict = status.ok() || status.is(StatusCode::too_few_matches) || status.is(StatusCode::no_model);
    return verdict ? Status{} : status;
  }
  if (!plausible(result)) {
    fail(SequenceVerdict::implausible);
    return {};
  }
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    if (w_.view_inliers[v] == 0) w_.contradicts[w_.match_of_view[v]] = 1;
  }
  push_camera(result.cam_from_world);
  tracks_.extend();
  s_.phase = SequencePhase::triangulate;
  return {};
}

bool SequenceRelation::plausible(const ResectionResult& resection) {
  // What does not move with the scene, such as the edge of a body that turns, puts the camera where the one before was,
  // whatever the matches of the scene say.
  if (s_.report.two_view.verdict == TwoViewVerdict::too_little_parallax &&
      resection.inliers < min_share_at_rest * static_cast<double>(w_.views.size())) {
    return false;
  }
  const RigidTransform previous = cam_from_world(s_.cameras[base_index()].pose);
  const RigidTransform step = compose(resection.cam_from_world, inverse(previous));
  if (det_acos(step.rotation(2, 2)) > s_.params.max_tilt_step_rad) return false;

  const double baseline = step.translation.norm();
  std::size_t count = 0;
  for (std::size_t v = 0; v < w_.views.size(); ++v) {
    const double* x = w_.views[v].position;
    if (w_.view_inliers[v] != 0) w_.ratios[count++] = (previous * Vec3(x[0], x[1], x[2])).z();
  }
  const double depth = upper_median(std::span(w_.ratios).first(count));
  const double footprint = depth * std::max(s_.camera.width / s_.camera.fx, s_.camera.height / s_.camera.fy);
  // A camera that goes around what it looks at moves by 2 sin(tilt / 2) of the distance.
  const double around = depth * std::sqrt(std::max(0.0, 2 - 2 * step.rotation(2, 2)));
  if (!(baseline <= s_.params.max_step_footprints * footprint + around)) return false;

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
  if (count < min_resection_inliers || !(baseline > 0)) return true;
  s_.report.scale_step = upper_median(std::span(w_.ratios).first(count)) / baseline;
  return s_.report.scale_step <= max_scale_step && s_.report.scale_step * max_scale_step >= 1;
}

}  // namespace ilp
