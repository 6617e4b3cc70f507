#include "fsw/motion/strip_check.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/motion/final_window.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

CalibrationCheckRecord record_of(const CameraCheck& check, const CameraEvidence& evidence) {
  CalibrationCheckRecord record;
  record.verdict = check.verdict;
  record.windows = evidence.windows;
  record.points = evidence.points;
  record.statistic = check.statistic;
  record.spread = check.spread;
  record.field = check.field;
  record.noise_px = check.noise_px;
  std::copy_n(check.corrections.begin(), intrinsic_count, record.corrections);
  std::copy_n(check.sigmas.begin(), intrinsic_count, record.correction_sigmas);
  record.worst = check.worst;
  record.worst_correction = check.worst_correction;
  record.worst_sigmas = check.worst_sigmas;
  record.cost = check.cost;
  return record;
}

Status event_of(const CalibrationCheckRecord& said) {
  if (said.verdict == CameraCheckVerdict::contradicts) {
    return {StatusCode::camera_contradicted, said.id, static_cast<std::int64_t>(said.worst)};
  }
  const double excess = excess_of(said.statistic, said.spread, said.field).largest();
  return {StatusCode::camera_unexplained, said.id, static_cast<std::int64_t>(1000 * std::fmin(excess, 1e6))};
}

}  // namespace

Status StripCheck::resume_after_records() {
  CalibrationCheckRecord check;
  const Status found = last(wiring_.store, check);
  if (found.is(StatusCode::not_found)) return {};
  if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
  if (!found.ok()) ILP_TRY(newest_id<StripRecord>(wiring_.store, check.id));
  // Of the newest strip nothing is known but that it is the one at work.
  cursor_.second = std::max<std::int64_t>(check.id - 1, 0);
  return {};
}

Result<bool> StripCheck::follow_strip(const CameraModel& camera, Status& event) {
  StripRecord& strip = work_.strip;
  const Status found = next(wiring_.store, cursor_.second, strip);
  if (found.is(StatusCode::not_found)) return false;
  if (found.is(StatusCode::record_damaged) || patience_.abandoned(input())) {
    // The newest one may still be written again.
    const std::int64_t id = found.ok() ? strip.id : found.a;
    StripRecord later;
    if (next(wiring_.store, id, later).is(StatusCode::not_found)) return false;
    ILP_TRY(end_strip(id));
    return true;
  }
  ILP_TRY(found);
  const std::int64_t id = state_.pose_id == 0 ? strip.first_keyframe_id : state_.pose_id + 1;
  if (id > strip.last_keyframe_id) {
    if (strip.end == StripEnd::open) return false;
    ILP_TRY(begin_window(camera, event));
    return true;
  }
  PoseRecord pose;
  // Poses come in the order of ids, and the oldest leave the store in time.
  const Status posed = next(wiring_.store, id - 1, pose);
  if (posed.is(StatusCode::not_found) || (posed.ok() && is_open(pose.state))) return false;
  const bool damaged = posed.is(StatusCode::record_damaged);
  if (!damaged) ILP_TRY(posed);
  if (damaged) pose.id = posed.a;
  state_.pose_id = std::min(pose.id, strip.last_keyframe_id);
  if (pose.id <= strip.last_keyframe_id && !damaged && pose.state == PoseState::final) ++state_.posed;
  // The window of adjustment after them may still see their points.
  if (state_.posed >= limits::max_calibration_views + window_length(wiring_.mission)) {
    ILP_TRY(begin_window(camera, event));
  }
  return true;
}

Status StripCheck::collect_keyframes() {
  workspace_.ids.clear();
  std::int64_t id = state_.window_first_id == 0 ? work_.strip.first_keyframe_id : state_.window_first_id;
  for (; id <= state_.pose_id && workspace_.ids.size() < workspace_.ids.capacity(); ++id) {
    PoseRecord pose;
    ILP_TAKE(const bool known, find(wiring_.store, id, pose));
    if (known && pose.state == PoseState::final) static_cast<void>(workspace_.ids.push_back(id));
  }
  return {};
}

Status StripCheck::begin_window(const CameraModel& camera, Status& event) {
  ILP_TRY(collect_keyframes());
  if (workspace_.ids.size() < least_window_views) return end_strip(work_.strip.id);
  const std::span<const std::int64_t> ids(workspace_.ids.data(), workspace_.ids.size());
  Status loaded = load_motion(wiring_.store, camera, false, ids, workspace_.motion);
  if (loaded.ok()) loaded = load_final_window(wiring_.store, camera, ids, state_.pose_id, workspace_.window);
  if (is_transient(loaded) && !patience_.abandoned(input())) return loaded;
  if (!loaded.ok()) {
    ILP_TRY(load_final_window(wiring_.store, camera, {}, 0, workspace_.window));
    event = loaded;
  }
  work_.window_loaded = true;
  return {};
}

Status StripCheck::end_window(const CameraModel& camera, Status& event) {
  StripCheckState after = state_;
  IntrinsicsEquations equations;
  const bool rolling = camera.readout_s < 0 || camera.readout_s > 0;
  const ReductionParams params{.motion = rolling ? &workspace_.motion : nullptr};
  const Status reduced =
      reduce_to_intrinsics(camera, params, workspace_.window, workspace_.equations, equations, after.evidence.field);
  if (reduced.ok()) add_window(equations, after.evidence);
  if (!reduced.ok()) event = reduced;
  after.window_first_id = workspace_.ids.back();
  after.posed -= std::min(after.posed, static_cast<std::uint32_t>(workspace_.ids.size() - 1));
  CalibrationCheckRecord said = record_of(judge(after.evidence, camera), after.evidence);
  said.id = work_.strip.id;
  said.first_keyframe_id = work_.strip.first_keyframe_id;
  said.last_keyframe_id = workspace_.ids.back();
  const bool alarm = said.verdict == CameraCheckVerdict::contradicts || said.verdict == CameraCheckVerdict::unexplained;
  if (alarm && said.verdict != after.reported) {
    event = event_of(said);
    after.reported = said.verdict;
  }
  // Windows without points say nothing, and must not take the place of what an earlier boot has found.
  ILP_TRY(commit(cursor_, after, after.evidence.windows > 0 ? &said : nullptr));
  work_.window_loaded = false;
  return {};
}

Status StripCheck::commit(const Cursor& after, StripCheckState& after_state, const CalibrationCheckRecord* said) {
  patience_.begin_writing();
  StepTransaction transaction(wiring_.store, wiring_.checkpoint);
  ILP_TRY(transaction.begin());
  if (said != nullptr) ILP_TRY(put(wiring_.store, *said));
  ILP_TRY(transaction.commit(after, after_state, cursor_, state_));
  patience_.end_writing();
  return {};
}

Status StripCheck::end_strip(std::int64_t strip_id) {
  StripCheckState next_strip;
  return commit(Cursor{cursor_.first, strip_id}, next_strip, nullptr);
}

Result<bool> StripCheck::step(const CameraModel& camera, Status& event) {
  if (!work_.window_loaded) return follow_strip(camera, event);
  ILP_TRY(end_window(camera, event));
  return true;
}

}  // namespace ilp
