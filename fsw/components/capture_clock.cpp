#include "fsw/components/capture_clock.hpp"

#include <algorithm>

namespace ilp {
namespace {

constexpr std::uint32_t layout = 1;
// On the way to a doubtful forecast: far enough to tell the speed, near enough that the overlap is safe.
constexpr double share_of_the_way = 0.6;

ForecastParams forecast_params(const MissionParameters& mission) {
  ForecastParams params;
  params.target_overlap = mission.target_overlap;
  return params;
}

}  // namespace

CaptureClock::CaptureClock(Store& store, const Camera& camera, Clock& clock, const MissionParameters& mission)
    : store_(store), camera_(camera), clock_(clock), mission_(mission) {}

Status CaptureClock::restore() {
  return restore_checkpoint(store_, ComponentId::capture_clock, cursor_, layout, state_);
}

void CaptureClock::want(TimeNs time_ns, CaptureSource source, Outcome& outcome) const {
  outcome.has_capture = true;
  CaptureRecord& capture = outcome.capture;
  capture.id = ++outcome.after.last_capture_id;
  capture.requested_ns = time_ns;
  capture.issued_ns = clock_.now();
  capture.source = source;
  if (source != CaptureSource::telecommand) outcome.after.own = {capture.id, time_ns};
}

bool CaptureClock::too_near(TimeNs time_ns, const State& state, TimeNs latest_exposure_ns) const {
  const TimeNs least = ns_from_seconds(mission_.capture_min_interval_s);
  if (time_ns - latest_exposure_ns < least) return true;
  for (const Wanted& other : state.telecommanded) {
    if (time_ns - other.time_ns < least && other.time_ns - time_ns < least) return true;
  }
  return false;
}

Status CaptureClock::accept_telecommand(const CommandRecord& command, Outcome& outcome) {
  const TimeNs now = clock_.now();
  FrameRecord latest;
  const Status found = last(store_, latest);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  State& after = outcome.after;
  want(command.at_ns, CaptureSource::telecommand, outcome);
  outcome.capture.command_id = command.id;
  outcome.capture.state = CaptureState::rejected;
  if (command.at_ns < now) {
    outcome.event = {StatusCode::capture_in_past, command.id, (now - command.at_ns) / 1000};
    return {};
  }
  const TimeNs latest_exposure = found.ok() ? latest.time_ns : now - ns_from_seconds(mission_.capture_min_interval_s);
  if (too_near(command.at_ns, after, latest_exposure)) {
    outcome.event = {StatusCode::capture_too_soon, command.id, ns_from_seconds(mission_.capture_min_interval_s) / 1000};
    return {};
  }
  if (!after.telecommanded.push_back({outcome.capture.id, command.at_ns})) {
    outcome.event = {StatusCode::capacity_exceeded, static_cast<std::int64_t>(after.telecommanded.size() + 1),
                     static_cast<std::int64_t>(max_telecommanded)};
    return {};
  }
  outcome.capture.state = CaptureState::pending;
  if (after.own.id != 0 && too_near(after.own.time_ns, after, latest_exposure)) {
    ILP_TRY(get(store_, after.own.id, outcome.superseded));
    after.own = {};
    if (outcome.superseded.state != CaptureState::pending) return {};
    outcome.superseded.state = CaptureState::superseded;
    outcome.has_superseded = true;
  }
  return {};
}

Status CaptureClock::handle_command(Outcome& outcome, bool& handled) {
  handled = false;
  CommandRecord command;
  const Status found = next(store_, cursor_.second, command);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  handled = true;
  outcome.cursor.second = command.id;
  if (command.kind == CommandKind::capture) return accept_telecommand(command, outcome);
  if (command.kind == CommandKind::end_strip && command.reason == StripEnd::end_of_flight) outcome.after.ended = true;
  return {};
}

Status CaptureClock::follow_keyframe(const OverlapRecord& overlap, const FrameRecord& frame, State& after) {
  // A frame from before may have been chosen when this one had moved too far.
  if (overlap.keyframe_id != 0 && overlap.keyframe_id != after.keyframe_id) {
    KeyframeRecord keyframe;
    ILP_TRY(get(store_, overlap.keyframe_id, keyframe));
    after.keyframe_id = keyframe.id;
    if (!select_place(keyframe.time_ns, after.path)) begin_path(keyframe.time_ns, after.path);
  }
  const auto decision = static_cast<OverlapDecision>(overlap.decision);
  if (decision == OverlapDecision::new_strip) {
    KeyframeRecord keyframe;
    ILP_TRY(last(store_, keyframe));
    after.keyframe_id = keyframe.id;
    begin_path(keyframe.time_ns, after.path);
    return {};
  }
  if (decision != OverlapDecision::skipped && decision != OverlapDecision::selected) return {};
  const Similarity2 moved{overlap.scale, overlap.rotation_rad, overlap.shift_x_px, overlap.shift_y_px};
  const bool trusted = frame.time_doubt == TimeDoubt::none;
  if (!extend_path(frame.width, frame.height, frame.time_ns, moved, trusted, after.path)) return {};
  if (decision == OverlapDecision::selected) {
    KeyframeRecord keyframe;
    ILP_TRY(last(store_, keyframe));
    after.keyframe_id = keyframe.id;
    if (!select_place(frame.time_ns, after.path)) begin_path(frame.time_ns, after.path);
  }
  return {};
}

Status CaptureClock::follow_overlap(Outcome& outcome, bool& handled) {
  handled = false;
  OverlapRecord overlap;
  const Status found = next(store_, cursor_.first, overlap);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  handled = true;
  outcome.cursor.first = overlap.id;
  FrameRecord frame;
  const Status known = get(store_, overlap.id, frame);
  if (!known.ok()) {
    outcome.event = known;
    return {};
  }
  outcome.after.width = frame.width;
  outcome.after.height = frame.height;
  return follow_keyframe(overlap, frame, outcome.after);
}

Status CaptureClock::forget_past_captures(State& after, bool& changed) {
  const TimeNs now = clock_.now();
  // Nothing can have become of a capture before its time.
  const auto is_over = [&](const Wanted& wanted, bool& over) -> Status {
    over = false;
    if (wanted.id == 0 || wanted.time_ns > now) return {};
    CaptureRecord capture;
    ILP_TRY(get(store_, wanted.id, capture));
    over = capture.state != CaptureState::pending;
    changed = changed || over;
    return {};
  };
  bool over = false;
  ILP_TRY(is_over(after.own, over));
  if (over) after.own = {};
  std::size_t kept = 0;
  for (const Wanted& wanted : after.telecommanded) {
    ILP_TRY(is_over(wanted, over));
    if (!over) after.telecommanded[kept++] = wanted;
  }
  while (after.telecommanded.size() > kept) after.telecommanded.pop_back();
  return {};
}

void CaptureClock::plan_regular(const FrameRecord* latest, TimeNs now, Outcome& outcome) const {
  const TimeNs interval = ns_from_seconds(mission_.capture_interval_s);
  State& after = outcome.after;
  // A camera that runs freely sets the beginning.
  if (!after.any_regular && latest != nullptr) after.last_regular_ns = latest->time_ns;
  if (!after.any_regular && latest == nullptr) {
    if (!camera_.triggered()) return;
    after.last_regular_ns = now - interval;
  }
  TimeNs time = after.last_regular_ns + interval;
  if (time < now) time += (now - time + interval - 1) / interval * interval;
  after.last_regular_ns = time;
  after.any_regular = true;
  const TimeNs latest_exposure =
      latest != nullptr ? latest->time_ns : time - ns_from_seconds(mission_.capture_min_interval_s);
  if (too_near(time, after, latest_exposure)) return;
  want(time, CaptureSource::regular, outcome);
}

void CaptureClock::choose_forecast_time(const FrameRecord& latest, TimeNs now, Outcome& outcome) {
  const State& after = outcome.after;
  const TimeNs earliest = std::max(latest.time_ns + ns_from_seconds(mission_.capture_min_interval_s), now);
  TimeNs time = std::max(latest.time_ns + ns_from_seconds(mission_.capture_safe_interval_s), now);
  CaptureSource source = CaptureSource::safe;
  MotionForecast::Overlap expected;
  motion_.fit(after.width, after.height, after.path, forecast_params(mission_));
  if (motion_.known()) {
    source = CaptureSource::forecast;
    const TimeNs longest = latest.time_ns + ns_from_seconds(mission_.capture_max_interval_s);
    time = motion_.time_of_target(earliest, std::max(longest, earliest));
    expected = motion_.overlap_at(time);
    const TimeNs part =
        latest.time_ns + ns_from_seconds(share_of_the_way * 1e-9 * static_cast<double>(time - latest.time_ns));
    if (expected.sigma > mission_.capture_max_sigma && part >= earliest) {
      source = CaptureSource::on_the_way;
      time = part;
      expected = motion_.overlap_at(time);
    }
  }
  if (too_near(time, after, latest.time_ns)) return;  // the telecommanded frame serves as well
  want(time, source, outcome);
  if (!motion_.known()) return;
  outcome.capture.overlap = expected.overlap;
  outcome.capture.overlap_sigma = expected.sigma;
  outcome.capture.speed_px_s = motion_.speed_px_s();
}

void CaptureClock::plan_forecast(const FrameRecord* latest, TimeNs now, Outcome& outcome) {
  if (latest == nullptr) {
    if (!camera_.triggered() || too_near(now, outcome.after, now - ns_from_seconds(mission_.capture_min_interval_s)))
      return;
    want(now, CaptureSource::safe, outcome);
  } else if (latest->id > cursor_.first) {
    // The overlap of the last frame is not known yet, and may be the one that never comes.
    if (now - latest->time_ns < ns_from_seconds(mission_.capture_safe_interval_s)) return;
    if (!too_near(now, outcome.after, latest->time_ns)) want(now, CaptureSource::safe, outcome);
  } else {
    choose_forecast_time(*latest, now, outcome);
  }
}

Status CaptureClock::plan(Outcome& outcome) {
  if (outcome.after.ended || outcome.after.own.id != 0) return {};
  FrameRecord latest;
  const Status found = last(store_, latest);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  const FrameRecord* const known = found.ok() ? &latest : nullptr;
  const TimeNs now = clock_.now();
  if (mission_.capture_mode == 0 && mission_.capture_interval_s > 0) plan_regular(known, now, outcome);
  if (mission_.capture_mode == 1) plan_forecast(known, now, outcome);
  return {};
}

Status CaptureClock::write(const Outcome& outcome) {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  if (outcome.has_superseded) ILP_TRY(put(store_, outcome.superseded));
  if (outcome.has_capture) ILP_TRY(put(store_, outcome.capture));
  ILP_TRY(save_checkpoint(store_, ComponentId::capture_clock, outcome.cursor, layout, outcome.after));
  ILP_TRY(transaction.commit());
  cursor_ = outcome.cursor;
  state_ = outcome.after;
  return {};
}

StepResult CaptureClock::step(TimeNs deadline) {
  static_cast<void>(deadline);
  Outcome outcome;
  outcome.after = state_;
  outcome.cursor = cursor_;
  bool handled = false;
  Status status = handle_command(outcome, handled);
  if (status.ok() && !handled) status = follow_overlap(outcome, handled);
  if (!status.ok()) return {status, false};
  bool changed = handled;
  if (!handled) {
    status = forget_past_captures(outcome.after, changed);
    if (status.ok()) status = plan(outcome);
    if (!status.ok()) return {status, false};
  }
  if (!changed && !outcome.has_capture) return {};
  const Status written = write(outcome);
  if (!written.ok()) return {written, true};
  return {outcome.event, true};
}

}  // namespace ilp
