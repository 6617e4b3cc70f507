#include "fsw/vision/multiview/sequence.hpp"

#include <bitset>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/sequence_adjustment.hpp"
#include "fsw/vision/multiview/sequence_beginning.hpp"
#include "fsw/vision/multiview/sequence_relation.hpp"
#include "fsw/vision/multiview/sequence_tracks.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t max_bundle_iterations = 20;
constexpr std::uint32_t max_readjust_iterations = 5;  // after outliers were dropped

Status check(const SequenceParams& p) {
  const bool good = p.window_keyframes >= 2 && p.window_keyframes <= limits::max_window_keyframes &&
                    p.resection_threshold_px > 0 && p.robust_px >= 0 && p.first_height >= 0 &&
                    p.max_first_depth_error > 0 && p.max_tilt_step_rad > 0 && p.max_step_footprints > 0;
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
    ILP_TRY(check(matches, back > 0 ? SequenceTracks(s_, w_).map_base() : s_.corners.size(), corners.size()));
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

bool Sequence::can_go_back_to(std::uint32_t back) const {
  // Before there are points, hardly any corner of an older keyframe is in a track that the newest one does not extend.
  // The rival motion of the first pair is kept for the newest keyframe alone.
  return back == 0 || (back < s_.cameras.size() && begun() && !s_.first_pair.ambiguous);
}

Status Sequence::step() {
  SequenceTracks tracks(s_, w_);
  SequenceRelation relation(s_, w_);
  SequenceBeginning beginning(s_, w_);
  SequenceAdjustment adjustment(s_, w_);
  switch (s_.phase) {
    case SequencePhase::idle:
      break;
    case SequencePhase::relate:
      return relation.relate();
    case SequencePhase::rank:
      return beginning.rank();
    case SequencePhase::begin:
      return beginning.begin_with_candidate();
    case SequencePhase::extend_from_pair:
      return beginning.extend_from_pair();
    case SequencePhase::decide:
      return relation.decide();
    case SequencePhase::resect:
      return relation.resect_camera();
    case SequencePhase::triangulate:
      return tracks.triangulate();
    case SequencePhase::adjust:
      return adjustment.adjust(max_bundle_iterations, SequencePhase::state_errors, SequencePhase::prune);
    case SequencePhase::prune:
      return tracks.prune();
    case SequencePhase::readjust:
      return adjustment.adjust(max_readjust_iterations, SequencePhase::restate_errors, SequencePhase::conclude);
    case SequencePhase::conclude:
      return conclude();
    case SequencePhase::relating:
      return relation.go_on_relating();
    case SequencePhase::state_errors:
      adjustment.state_errors(max_bundle_iterations, SequencePhase::prune);
      break;
    case SequencePhase::restate_errors:
      adjustment.state_errors(max_readjust_iterations, SequencePhase::conclude);
      break;
  }
  return {};
}

Status Sequence::add_keyframe(std::int64_t keyframe_id, const Corners& corners, const Matches& matches_to_previous,
                              std::uint64_t seed, SequenceReport& report) {
  ILP_TRY(begin_keyframe(keyframe_id, corners, matches_to_previous, seed));
  while (!idle()) ILP_TRY(step());  // bound: the steps of one keyframe
  report = s_.report;
  return {};
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
  SequenceTracks(s_, w_).finish();
  s_.corners = s_.new_corners;
  s_.report.verdict = SequenceVerdict::ok;
  s_.phase = SequencePhase::idle;
  return {};
}

bool Sequence::begin_with_best_pair() {
  if (!can_begin() || s_.phase != SequencePhase::idle) return false;
  s_.strip_open = false;
  s_.dropped.clear();
  s_.report = {};
  s_.phase = SequencePhase::begin;
  return true;
}

Status Sequence::flush() {
  if (s_.phase != SequencePhase::idle) return StatusCode::not_ready;
  s_.strip_open = false;
  if (s_.cameras.empty()) return {};
  s_.final_count = newest() + 1;
  for (SequenceCamera& camera : s_.cameras) camera.final_pose = true;
  SequenceTracks(s_, w_).finish();
  return {};
}

bool Sequence::take_final_camera(SequenceCamera& camera) {
  if (s_.taken_count >= s_.final_count) return false;
  const std::size_t index = s_.taken_count - s_.oldest;
  camera = s_.cameras[index];
  const double factor = s_.params.error_factor * s_.params.error_factor;
  covariance_of_camera(s_.covariance, index, camera.covariance);
  for (double& x : camera.covariance) x *= factor;
  const IntrinsicsCovariance lens = intrinsics_covariance(s_.params.lens_covariance);
  add_error_of_lens(s_.covariance, index, lens, camera.covariance);
  if (index > 0) {
    covariance_of_step(s_.covariance, index, cam_from_world(s_.cameras[index - 1].pose), cam_from_world(camera.pose),
                       camera.step_covariance);
    for (double& x : camera.step_covariance) x *= factor;
  }
  ++s_.taken_count;
  return true;
}

double Sequence::depth_error_of_lens(const SequenceCamera& camera, double depth) const {
  for (std::size_t i = 1; i < s_.cameras.size(); ++i) {
    if (s_.cameras[i].keyframe_id != camera.keyframe_id) continue;
    const StripStep step{i, cam_from_world(s_.cameras[i - 1].pose), cam_from_world(camera.pose)};
    return ilp::depth_error_of_lens(s_.covariance, step, s_.camera, intrinsics_covariance(s_.params.lens_covariance),
                                    depth);
  }
  return 0;
}

void Sequence::corners_of(std::uint32_t back, Corners& corners) const {
  SequenceTracks(s_, w_).corners_of(back, corners);
}

std::size_t Sequence::count_corners(std::uint32_t back) const {
  return SequenceTracks(s_, w_).count_corners(back);
}

bool Sequence::take_final_point(FinalPoint& point) {
  return SequenceTracks(s_, w_).take_final_point(point);
}

}  // namespace ilp
