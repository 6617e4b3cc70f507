#include "fsw/imaging/capture_clock.hpp"

#include <algorithm>
#include <limits>

#include "fsw/imaging/images_missed.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// Before a suspect forecast time: late enough to measure the speed, early enough that the overlap is safe.
constexpr double share_of_the_way = 0.7;
// A planned time stays if a better one is as near as this, or if the camera may be exposing already.
constexpr TimeNs replan_threshold_ns = 20 * ns_per_ms;
constexpr TimeNs too_late_to_plan_ns = 2 * minor_frame_ns;
// Until then newer places may still move the image of a place.
constexpr TimeNs place_lead_ns = 500 * ns_per_ms;
// Frames that are nearer show the motion hardly better than the noise of their registration.
constexpr TimeNs shortest_burst_step_ns = 150 * ns_per_ms;
// Images that follow each other as fast as this show the motion themselves.
constexpr double frequent_interval_s = 1;
// A new pose changes earlier ones, as far back as the adjustment window reaches.
constexpr std::int64_t attitude_memory = limits::max_window_keyframes;

template <typename ClockState>
void restart_path(const KeyframeRecord& keyframe, ClockState& state) {
  state.keyframe_id = state.first_keyframe_id = keyframe.id;
  for (double& q : state.q_first_from_world) q = 0;
  begin_path(keyframe.time_ns, state.path);
}

template <typename ClockOutcome>
void reject(const Status& reason, ClockOutcome& outcome) {
  outcome.capture.state = CaptureState::rejected;
  outcome.capture.reason = static_cast<std::uint16_t>(reason.code);
  outcome.event = reason;
}

bool is_forecast(CaptureSource source) {
  return source == CaptureSource::forecast || source == CaptureSource::on_the_way;
}

}  // namespace

constexpr CheckpointForm CaptureClock::checkpoint = checkpoint_form<State>(component_id);

CaptureClock::CaptureClock(Tables store, const Camera& camera, Clock& clock, const MissionParameters& mission)
    : wiring_{store, ValidView<Tables::tables>(store), camera, clock, mission} {}

Status CaptureClock::restore() {
  const Status status = restore_checkpoint(wiring_.whole, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  begin_ids<CaptureRecord>(wiring_.whole, state_.last_capture_id);
  work_ = {};
  if (!status.ok()) ILP_TRY(resume_after_records(status.is(StatusCode::checkpoint_lost)));
  return status;
}

Status CaptureClock::resume_after_records(bool lost) {
  std::int64_t newest = 0;
  ILP_TRY(newest_id<CaptureRecord>(wiring_.whole, newest));
  // The mode's captures since then may come in addition.
  if (newest > state_.last_capture_id) state_.own = {};
  state_.last_capture_id = std::max(state_.last_capture_id, newest);
  if (!lost) return {};
  // Commands from before the checkpoint are not carried out now.
  ILP_TRY(resume_track(wiring_.whole, state_.at_places));
  ILP_TRY(newest_id<OverlapRecord>(wiring_.whole, cursor_.first));
  ILP_TRY(newest_id<CommandRecord>(wiring_.whole, cursor_.second));
  return newest_id<PoseRecord>(wiring_.whole, state_.last_pose_id);
}

void CaptureClock::want(TimeNs time_ns, CaptureSource source, Outcome& outcome) const {
  outcome.has_capture = true;
  const std::int64_t id = ++outcome.after.last_capture_id;
  outcome.capture = {.id = id, .requested_ns = time_ns, .issued_ns = wiring_.clock.now(), .source = source};
  if (source != CaptureSource::telecommand) outcome.after.own = {id, time_ns};
}

bool CaptureClock::too_near(TimeNs time_ns, const State& state, TimeNs latest_exposure_ns) const {
  const TimeNs least = ns_from_seconds(wiring_.mission.capture_min_interval_s);
  if (time_ns - latest_exposure_ns < least) return true;
  for (const Wanted& other : state.telecommanded) {
    if (time_ns - other.time_ns < least && other.time_ns - time_ns < least) return true;
  }
  return false;
}

Status CaptureClock::accept_telecommand(const CommandRecord& command, Outcome& outcome) {
  const TimeNs now = wiring_.clock.now();
  FrameRecord latest;
  const Status found = last(wiring_.store, latest);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  State& after = outcome.after;
  const bool soon = command.kind == CommandKind::capture_soon;
  const TimeNs at = soon && command.at_ns < now ? now : command.at_ns;
  want(at, CaptureSource::telecommand, outcome);
  outcome.capture.command_id = command.id;
  if (at < now) {
    reject({StatusCode::capture_in_past, command.id, (now - at) / 1000}, outcome);
    return {};
  }
  const TimeNs latest_exposure =
      found.ok() ? latest.time_ns : now - ns_from_seconds(wiring_.mission.capture_min_interval_s);
  if (too_near(at, after, latest_exposure)) {
    reject({StatusCode::capture_too_soon, command.id, ns_from_seconds(wiring_.mission.capture_min_interval_s) / 1000},
           outcome);
    return {};
  }
  if (!after.telecommanded.push_back({outcome.capture.id, at})) {
    reject({StatusCode::capacity_exceeded, static_cast<std::int64_t>(after.telecommanded.size() + 1),
            static_cast<std::int64_t>(max_telecommanded)},
           outcome);
    return {};
  }
  if (after.own.id != 0 && too_near(after.own.time_ns, after, latest_exposure)) {
    ILP_TAKE(const bool found_own, find(wiring_.store, after.own.id, outcome.superseded));
    after.own = {};
    if (!found_own || outcome.superseded.state != CaptureState::pending) return {};
    outcome.superseded.state = CaptureState::superseded;
    outcome.has_superseded = true;
  }
  return {};
}

Result<bool> CaptureClock::handle_command(Outcome& outcome) {
  CommandRecord command;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, cursor_.second, command));
  if (!found) return false;
  outcome.cursor.second = command.id;
  const bool wanted = command.kind == CommandKind::capture || command.kind == CommandKind::capture_soon;
  if (wanted) ILP_TRY(accept_telecommand(command, outcome));
  if (command.kind == CommandKind::capture_place) {
    const TimeNs now = wiring_.clock.now();
    const Status accepted = accept_place(command, wiring_.mission, now, outcome.after.at_places);
    if (!accepted.ok()) {
      want(now, CaptureSource::telecommand, outcome);
      outcome.capture.command_id = command.id;
      reject(accepted, outcome);
    }
  }
  if (command.kind == CommandKind::end_strip && command.reason == StripEnd::end_of_flight) outcome.after.ended = true;
  return true;
}

Status CaptureClock::follow_keyframe(const OverlapRecord& overlap, const FrameRecord& frame, State& after) {
  // An earlier frame may have been chosen when this one had moved too far.
  if (overlap.keyframe_id != 0 && overlap.keyframe_id != after.keyframe_id) {
    KeyframeRecord keyframe;
    ILP_TRY(get(wiring_.store, overlap.keyframe_id, keyframe));
    after.keyframe_id = keyframe.id;
    if (!select_place(keyframe.time_ns, after.path)) restart_path(keyframe, after);
  }
  const auto decision = overlap.decision;
  if (decision == OverlapDecision::new_strip) {
    KeyframeRecord keyframe;
    ILP_TRY(last(wiring_.store, keyframe));
    restart_path(keyframe, after);
    return {};
  }
  if (decision != OverlapDecision::skipped && decision != OverlapDecision::selected) return {};
  const Similarity2 moved{overlap.scale, overlap.rotation_rad, overlap.shift_x_px, overlap.shift_y_px};
  const bool trusted = frame.time_doubt == TimeDoubt::none;
  if (!extend_path(frame.width, frame.height, frame.time_ns, moved, trusted, after.path)) return {};
  if (decision == OverlapDecision::selected) {
    KeyframeRecord keyframe;
    ILP_TRY(last(wiring_.store, keyframe));
    after.keyframe_id = keyframe.id;
    if (!select_place(frame.time_ns, after.path)) restart_path(keyframe, after);
  }
  return {};
}

Result<bool> CaptureClock::follow_overlap(Outcome& outcome) {
  OverlapRecord overlap;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, cursor_.first, overlap));
  if (!found) return false;
  outcome.cursor.first = overlap.id;
  FrameRecord frame;
  const Status read = get(wiring_.store, overlap.id, frame);
  ILP_TAKE(const bool known, found_by(read));
  if (!known) {
    outcome.event = read;
    return true;
  }
  outcome.after.width = frame.width;
  outcome.after.height = frame.height;
  const Status followed = follow_keyframe(overlap, frame, outcome.after);
  ILP_TAKE(const bool complete, found_by(followed));
  if (complete) return true;
  // The overlap is damaged, so this frame adds nothing to the path.
  outcome.after = state_;
  outcome.event = followed;
  return true;
}

Status CaptureClock::take_attitude(const PoseRecord& pose, double focal_px, State& after) {
  KeyframeRecord keyframe;
  ILP_TRY(get(wiring_.store, pose.id, keyframe));
  if (pose.id == after.first_keyframe_id) std::copy_n(pose.q_cam_from_world, 4, after.q_first_from_world);
  const double* const q = after.q_first_from_world;
  if (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] == 0) return {};
  const Mat3 first_from_frame =
      rotation_from_quaternion(q) * rotation_from_quaternion(pose.q_cam_from_world).transpose();
  const Vec3 axis = first_from_frame.col(2);
  if (!(axis.z() > 0)) return {};
  const double x = focal_px * axis.x() / axis.z(), y = focal_px * axis.y() / axis.z();
  after.tilt_has_changed = set_tilt(keyframe.time_ns, x, y, after.path) || after.tilt_has_changed;
  return {};
}

Result<bool> CaptureClock::follow_pose(Outcome& outcome) {
  PoseRecord pose;
  ILP_TAKE(const bool found, find_next_valid(wiring_.store, state_.last_pose_id, pose));
  if (!found) return false;
  State& after = outcome.after;
  after.last_pose_id = pose.id;
  if (wiring_.mission.capture_mode != CaptureMode::forecast) return true;
  CameraRecord camera;
  ILP_TAKE(const bool seen, found_by(get_camera(wiring_.store, camera_id, camera)));
  if (!seen) return true;
  const std::int64_t oldest = std::max(after.first_keyframe_id, pose.id - attitude_memory);
  for (std::int64_t id = oldest; id <= pose.id; ++id) {
    PoseRecord known;
    ILP_TAKE(const bool read, find(wiring_.store, id, known));
    if (!read || known.state == PoseState::failed || known.state == PoseState::trial_failed) continue;
    ILP_TRY(found_by(take_attitude(known, camera.fx, after)).status());
  }
  return true;
}

Result<bool> CaptureClock::forget_past_captures(State& after) {
  bool changed = false;
  const TimeNs now = wiring_.clock.now();
  const auto is_over = [&](const Wanted& wanted) -> Result<bool> {
    // A capture has no result before its time.
    if (wanted.id == 0 || wanted.time_ns > now) return false;
    CaptureRecord capture;
    ILP_TAKE(const bool found, find(wiring_.store, wanted.id, capture));
    const bool over = !found || capture.state != CaptureState::pending;
    changed = changed || over;
    return over;
  };
  ILP_TAKE(const bool own_is_over, is_over(after.own));
  if (own_is_over) after.own = {};
  std::size_t kept = 0;
  for (const Wanted& wanted : after.telecommanded) {
    ILP_TAKE(const bool over, is_over(wanted));
    if (!over) after.telecommanded[kept++] = wanted;
  }
  while (after.telecommanded.size() > kept) after.telecommanded.pop_back();
  return changed;
}

void CaptureClock::plan_regular(double interval_s, const FrameRecord* latest, TimeNs now, Outcome& outcome) const {
  const TimeNs interval = std::max(ns_from_seconds(interval_s), minor_frame_ns);
  State& after = outcome.after;
  // A camera that runs freely sets the beginning.
  if (!after.any_regular && latest != nullptr) after.last_regular_ns = latest->time_ns;
  if (!after.any_regular && latest == nullptr) {
    if (!wiring_.camera.triggered()) return;
    after.last_regular_ns = now - interval;
  }
  TimeNs time = after.last_regular_ns + interval;
  if (time < now) time += (now - time + interval - 1) / interval * interval;
  after.last_regular_ns = time;
  after.any_regular = true;
  const TimeNs latest_exposure =
      latest != nullptr ? latest->time_ns : time - ns_from_seconds(wiring_.mission.capture_min_interval_s);
  if (too_near(time, after, latest_exposure)) return;
  want(time, CaptureSource::regular, outcome);
}

CaptureClock::ForecastTime CaptureClock::forecast_time(const FrameRecord& latest, TimeNs now, const State& state) {
  const TimeNs earliest = std::max(latest.time_ns + ns_from_seconds(wiring_.mission.capture_min_interval_s), now);
  ForecastTime result;
  result.time_ns = std::max(latest.time_ns + ns_from_seconds(wiring_.mission.capture_safe_interval_s), now);
  workspace_.motion.fit(state.width, state.height, state.path, wiring_.mission.target_overlap);
  if (!workspace_.motion.known()) return result;
  result.source = CaptureSource::forecast;
  const TimeNs longest = latest.time_ns + ns_from_seconds(wiring_.mission.capture_max_interval_s);
  result.time_ns = workspace_.motion.time_of_target(earliest, std::max(longest, earliest));
  result.expected = workspace_.motion.overlap_at(result.time_ns);
  const TimeNs part =
      latest.time_ns + ns_from_seconds(share_of_the_way * 1e-9 * static_cast<double>(result.time_ns - latest.time_ns));
  if (result.expected.sigma > wiring_.mission.capture_max_sigma && part >= earliest) {
    result = {part, CaptureSource::on_the_way, workspace_.motion.overlap_at(part)};
  }
  return result;
}

void CaptureClock::want_forecast(const ForecastTime& forecast, Outcome& outcome) {
  want(forecast.time_ns, forecast.source, outcome);
  if (!workspace_.motion.known()) return;
  outcome.capture.overlap = forecast.expected.overlap;
  outcome.capture.overlap_sigma = forecast.expected.sigma;
  outcome.capture.speed_px_s = workspace_.motion.speed_px_s();
}

Status CaptureClock::reconsider(const FrameRecord* latest, TimeNs now, Outcome& outcome) {
  State& after = outcome.after;
  if (latest == nullptr || latest->id > cursor_.first || after.own.time_ns - now < too_late_to_plan_ns) return {};
  if (after.own.time_ns == after.burst_of_ns) return {};
  CaptureRecord planned;
  ILP_TAKE(const bool found, find(wiring_.store, after.own.id, planned));
  if (!found) after.own = {};
  if (!found || planned.state != CaptureState::pending || !is_forecast(planned.source)) return {};
  const ForecastTime better = forecast_time(*latest, now, after);
  const TimeNs change = better.time_ns - planned.requested_ns;
  if (change < replan_threshold_ns && -change < replan_threshold_ns) return {};
  if (too_near(better.time_ns, after, latest->time_ns)) return {};
  planned.state = CaptureState::superseded;
  outcome.superseded = planned;
  outcome.has_superseded = true;
  want_forecast(better, outcome);
  return {};
}

void CaptureClock::plan_forecast(const FrameRecord* latest, TimeNs now, Outcome& outcome) {
  if (latest == nullptr) {
    if (!wiring_.camera.triggered() ||
        too_near(now, outcome.after, now - ns_from_seconds(wiring_.mission.capture_min_interval_s)))
      return;
    want(now, CaptureSource::safe, outcome);
  } else if (latest->id > cursor_.first) {
    // The overlap of the last frame is not known yet, and may never be.
    if (now - latest->time_ns < ns_from_seconds(wiring_.mission.capture_safe_interval_s)) return;
    if (!too_near(now, outcome.after, latest->time_ns)) want(now, CaptureSource::safe, outcome);
  } else {
    const ForecastTime forecast = forecast_time(*latest, now, outcome.after);
    // The telecommanded frame serves as well.
    if (!too_near(forecast.time_ns, outcome.after, latest->time_ns)) want_forecast(forecast, outcome);
  }
}

Status CaptureClock::plan_place(Outcome& outcome) {
  State& after = outcome.after;
  auto& targets = after.at_places.targets;
  if (targets.empty()) return {};
  const TimeNs now = wiring_.clock.now(), least = ns_from_seconds(wiring_.mission.capture_min_interval_s);
  FrameRecord latest;
  ILP_TAKE(const bool any, read_by(last(wiring_.store, latest)));
  const TimeNs latest_exposure = any ? latest.time_ns : now - least;
  const Body body = wiring_.mission.body;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const PlaceTarget target = targets[i];
    const bool limited = target.limit_ns > 0;
    const TimeNs latest_time = limited ? target.limit_ns : std::numeric_limits<TimeNs>::max();
    const Approach approach = nearest_approach(body, after.at_places.track, target, now, latest_time);
    const bool over = after.ended || (limited && now > target.limit_ns);
    const bool due = !over && approach.within(target.distance_m) && approach.time_ns - now <= place_lead_ns &&
                     !after.telecommanded.full() && !too_near(approach.time_ns, after, latest_exposure);
    if (!due && !over) continue;
    targets.erase(i);
    if (due) {
      ILP_TRY(accept_telecommand(
          {.id = target.command_id, .kind = CommandKind::capture_soon, .at_ns = approach.time_ns}, outcome));
      outcome.capture.distance_m = approach.distance_m;
      return {};
    }
    const Status fault = place_fault(body, after.at_places.track, target, now);
    want(now, CaptureSource::telecommand, outcome);
    outcome.capture.command_id = target.command_id;
    if (fault.is(StatusCode::place_missed)) outcome.capture.distance_m = static_cast<double>(fault.b);
    reject(fault, outcome);
    return {};
  }
  return {};
}

Status CaptureClock::plan(Outcome& outcome) {
  const bool planned = outcome.after.own.id != 0;
  const bool updates = outcome.after.tilt_has_changed;
  outcome.after.tilt_has_changed = false;
  if (outcome.after.ended || (planned && !updates)) return {};
  FrameRecord latest;
  const Status found = last(wiring_.store, latest);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  const FrameRecord* const known = found.ok() ? &latest : nullptr;
  const TimeNs now = wiring_.clock.now();
  if (planned) return reconsider(known, now, outcome);
  if (wiring_.mission.safe_mode) {
    plan_regular(wiring_.mission.capture_safe_interval_s, known, now, outcome);
    return {};
  }
  if (wiring_.mission.capture_mode == CaptureMode::regular && wiring_.mission.capture_interval_s > 0) {
    plan_regular(wiring_.mission.capture_interval_s, known, now, outcome);
  }
  if (wiring_.mission.capture_mode == CaptureMode::forecast) plan_forecast(known, now, outcome);
  return {};
}

Status CaptureClock::plan_burst(Outcome& outcome) const {
  const MissionParameters& mission = wiring_.mission;
  const bool frequent =
      mission.capture_mode == CaptureMode::regular && mission.capture_interval_s <= frequent_interval_s;
  State& after = outcome.after;
  if (!mission.capture_burst || mission.safe_mode || frequent || after.ended) return {};
  const TimeNs step = std::max(ns_from_seconds(mission.capture_min_interval_s), shortest_burst_step_ns);
  constexpr auto half = static_cast<TimeNs>(burst_frames / 2);
  const TimeNs now = wiring_.clock.now();
  // The first one is still to be planned in time.
  const TimeNs soon = now + half * step + too_late_to_plan_ns;
  TimeNs due = soon + 1;
  if (after.own.id != 0 && after.own.time_ns > after.burst_of_ns) due = after.own.time_ns;
  for (const Wanted& other : after.telecommanded) {
    if (other.time_ns > after.burst_of_ns) due = std::min(due, other.time_ns);
  }
  if (due > soon) return {};
  CameraRecord camera;
  ILP_TAKE(const bool known, found_by(get_camera(wiring_.store, camera_id, camera)));
  if (!known || !has_rolling_shutter(camera)) return {};
  // The camera may still be busy with the burst before, and with the capture that it was beside.
  TimeNs free_from = now + 1;
  if (after.burst_of_ns > 0) free_from = std::max(free_from, after.burst_of_ns + step);
  if (!after.burst.empty()) free_from = std::max(free_from, after.burst.back().time_ns + step);
  after.burst_of_ns = due;
  after.burst.clear();
  for (TimeNs i = -half; i <= half; ++i) {
    const TimeNs time = due + i * step;
    const bool beside_own = after.own.id != 0 && distance(after.own.time_ns, time) < step;
    if (time < free_from || beside_own || too_near(time, after, time - step)) continue;
    const std::int64_t id = ++after.last_capture_id;
    static_cast<void>(after.burst.push_back({id, time}));
    static_cast<void>(
        outcome.burst.push_back({.id = id, .requested_ns = time, .issued_ns = now, .source = CaptureSource::burst}));
  }
  return {};
}

Status CaptureClock::clear_burst(Outcome& outcome) const {
  if (!outcome.has_capture || outcome.capture.state != CaptureState::pending) return {};
  const TimeNs least = ns_from_seconds(wiring_.mission.capture_min_interval_s);
  std::size_t kept = 0;
  FixedVector<Wanted, burst_frames>& burst = outcome.after.burst;
  for (const Wanted& beside : burst) {
    CaptureRecord capture;
    if (distance(beside.time_ns, outcome.capture.requested_ns) < least) {
      ILP_TAKE(const bool found, find(wiring_.store, beside.id, capture));
      if (!found) continue;
    }
    const bool gives_way = capture.id != 0 && capture.state == CaptureState::pending;
    if (!gives_way) {
      burst[kept++] = beside;
      continue;
    }
    capture.state = CaptureState::superseded;
    static_cast<void>(outcome.burst.push_back(capture));
  }
  while (burst.size() > kept) burst.pop_back();
  return {};
}

Status CaptureClock::write(Outcome& outcome) {
  StepTransaction transaction(wiring_.whole, checkpoint);
  ILP_TRY(transaction.begin());
  if (outcome.has_superseded) ILP_TRY(put(wiring_.store, outcome.superseded));
  if (outcome.has_capture) ILP_TRY(put(wiring_.store, outcome.capture));
  for (const CaptureRecord& capture : outcome.burst) ILP_TRY(put(wiring_.store, capture));
  return transaction.commit(outcome.cursor, outcome.after, cursor_, state_);
}

void CaptureClock::note_lock() {
  CaptureRecord own;
  const bool pending =
      state_.own.id != 0 && get(wiring_.store, state_.own.id, own).ok() && own.state == CaptureState::pending;
  // Acquisition holds the image of a pending capture, and counts from there.
  if (!pending) work_.lock.note(true, wiring_.clock.now());
}

StepResult CaptureClock::step() {
  Outcome outcome;
  outcome.after = state_;
  outcome.cursor = cursor_;
  Result<bool> handled = handle_command(outcome);
  if (handled.ok() && !handled.value()) handled = follow_overlap(outcome);
  if (handled.ok() && !handled.value()) handled = follow_pose(outcome);
  if (handled.ok() && !handled.value()) {
    handled = follow_place(wiring_.store, wiring_.mission, outcome.after.at_places);
  }
  if (!handled.ok()) return {handled.status(), false};
  bool changed = handled.value();
  if (!changed) {
    const Result<bool> forgotten = forget_past_captures(outcome.after);
    Status planned = forgotten.ok() ? plan_place(outcome) : forgotten.status();
    if (planned.ok() && !outcome.has_capture) planned = plan(outcome);
    if (!planned.ok()) return {planned, false};
    const Status beside = plan_burst(outcome);
    if (!beside.ok()) return {beside, false};
    changed = state_.tilt_has_changed || forgotten.value();
  }
  if (!changed && !outcome.has_capture && outcome.burst.empty()) return {};
  const Status cleared = clear_burst(outcome);
  if (!cleared.ok()) return {cleared, false};
  const bool regular = wiring_.mission.safe_mode || wiring_.mission.capture_mode == CaptureMode::regular;
  const TimeNs wanted_before = regular && state_.any_regular ? state_.last_regular_ns : work_.lock.begin_ns;
  const Status written = write(outcome);
  if (written.is(StatusCode::store_locked)) note_lock();
  if (!written.ok()) return {written, true};
  if (work_.lock.taken() && outcome.has_capture) {
    const std::int64_t lost = images_missed(wiring_.mission, wanted_before, outcome.capture.requested_ns - 1);
    if (lost > 0 && outcome.event.ok()) {
      outcome.event = {StatusCode::images_lost, lost, (wiring_.clock.now() - work_.lock.begin_ns) / ns_per_ms};
    }
    work_.lock = {};
  }
  return {outcome.event, true};
}

}  // namespace ilp
