#include "fsw/imaging/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "fsw/base/crc.hpp"
#include "fsw/imaging/images_missed.hpp"
#include "fsw/shared/new_command.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int32_t steady = 4;     // intervals that agreed before the period is trusted
constexpr std::int32_t steadiest = 8;  // limit of the count, which single deviations reduce
// A triggered exposure that is stamped farther off than this was not stamped by the camera's own clock.
constexpr TimeNs trigger_tolerance_ns = 20 * ns_per_ms;
// A camera that exposes exactly at the trigger and also at times of its own gets a wanted time this much ahead.
constexpr TimeNs trigger_lead_ns = ns_per_s;
// More than a minor frame plus the transfer of an image.
constexpr TimeNs late_ns = 500 * ns_per_ms;
// If camera and board share a clock, stamps are better than this; otherwise they are of no use.
constexpr TimeNs clock_tolerance_ns = 100 * ns_per_ms;
// A camera that runs freely counts as silent after this many of its periods, and not before the shortest time.
constexpr TimeNs periods_until_silent = 5;
constexpr TimeNs shortest_silence_ns = 10 * ns_per_s;
constexpr TimeNs unknown_silence_ns = 60 * ns_per_s;
/// The longest time for which a frame waits until the store takes it.
constexpr TimeNs longest_hold_ns = 3600 * ns_per_s;

/// The vehicle swings: the largest speed of the ground counts, and fades by this share with every image.
constexpr double speed_fading = 0.125;

bool is_uniform(GrayView image) {
  for (std::int32_t y = 0; y < image.height; ++y) {
    for (std::int32_t x = 0; x < image.width; ++x) {
      if (image.row(y)[x] != image.row(0)[0]) return false;
    }
  }
  return true;
}

}  // namespace

constexpr CheckpointForm Acquisition::checkpoint = checkpoint_form<State>(component_id);

Acquisition::Acquisition(Tables store, Camera& camera, Clock& clock, const MissionParameters& mission)
    : store_(store), camera_(camera), clock_(clock), mission_(mission) {}

Status Acquisition::restore() {
  const Status status = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  begin_ids<FrameRecord>(store_, cursor_.first);
  ILP_TRY(resume_after_records());
  // Counter and period of a previous life are not valid for this one.
  if (camera_.restarts_counter()) {
    state_.any = false;
    state_.last_sequence = -1;
  }
  restored_sequence_ = state_.last_sequence;
  heard_ns_ = -1;
  silent_ = false;
  exposure_.reset();
  speed_px_s_ = 0;
  next_event_ = {};
  locked_ns_ = unlocked_ns_ = seen_sequence_ = -1;
  held_by_lock_ = false;
  return status;
}

Status Acquisition::resume_after_records() {
  FrameRecord newest;
  const Status found = last(store_, newest);
  if (is_transient(found)) return found;
  const std::int64_t known = cursor_.first;
  ILP_TRY(newest_id<FrameRecord>(store_, newest.id));
  cursor_.first = std::max(known, newest.id);
  if (!found.ok() || cursor_.first == known) return {};
  state_.last_sequence = newest.sequence;
  state_.last_time_ns = newest.time_ns;
  state_.any = true;
  state_.any_kept = true;
  return {};
}

void Acquisition::remove_pending(std::size_t at, State& after) {
  for (std::size_t i = at + 1; i < after.pending.size(); ++i) after.pending[i - 1] = after.pending[i];
  after.pending.pop_back();
}

Status Acquisition::learn_captures(Outcome& outcome, bool& changed) {
  State& after = outcome.after;
  // Bounded by the capacity: further captures wait.
  while (!after.pending.full()) {
    CaptureRecord capture;
    const Status found = next(store_, outcome.cursor.second, capture);
    if (found.is(StatusCode::not_found)) return {};
    changed = true;
    if (found.is(StatusCode::record_damaged)) {
      outcome.cursor.second = found.a;
      outcome.event = found;
      continue;
    }
    ILP_TRY(found);
    outcome.cursor.second = capture.id;
    if (capture.state != CaptureState::pending) continue;
    static_cast<void>(after.pending.push_back({capture.id, capture.requested_ns}));
    for (std::size_t i = after.pending.size() - 1; i > 0 && after.pending[i].time_ns < after.pending[i - 1].time_ns;
         --i)
      std::swap(after.pending[i], after.pending[i - 1]);
  }
  return {};
}

Status Acquisition::give_up_captures(Outcome& outcome, bool& changed) {
  State& after = outcome.after;
  if (after.pending.empty()) return {};
  const Pending first = after.pending[0];
  CaptureRecord capture;
  const Status found = get(store_, first.id, capture);
  if (is_transient(found)) return found;
  // No request waits for a capture that no longer exists.
  const bool superseded = !found.ok() || capture.state != CaptureState::pending;
  if (!superseded && clock_.now() - first.time_ns <= ns_from_seconds(mission_.capture_timeout_s)) return {};
  changed = true;
  remove_pending(0, after);
  if (superseded) return {};
  capture.state = CaptureState::no_frame;
  outcome.capture = capture;
  outcome.has_capture = true;
  outcome.event = {StatusCode::capture_missed, first.id, ns_from_seconds(mission_.capture_timeout_s) / ns_per_ms};
  return {};
}

Status Acquisition::find_repetition(const CameraFrame& taken, Outcome& outcome, bool& repeated) {
  State& after = outcome.after;
  repeated = state_.any && taken.sequence <= state_.last_sequence;
  if (repeated) {
    const bool again = taken.sequence == state_.last_sequence;
    outcome.event = {again ? StatusCode::frame_duplicated : StatusCode::frame_out_of_order, taken.sequence,
                     state_.last_sequence};
    return {};
  }
  const GrayView pixels = image_.view();
  const std::uint32_t crc = crc32({pixels.data, pixels.area()});
  // A sensor's noise never repeats: the same bytes are the same exposure, unless all pixels are black or saturated.
  repeated = state_.any && crc == state_.last_crc32 && !is_uniform(pixels);
  if (repeated) outcome.event = {StatusCode::frame_duplicated, taken.sequence, state_.last_sequence};
  after.last_crc32 = crc;
  return {};
}

void Acquisition::learn_period(TimeNs since_last, std::int64_t exposures, State& after) const {
  const TimeNs interval = since_last / std::max<std::int64_t>(exposures, 1);
  const bool holds = after.period_ns > 0 && distance(interval, after.period_ns) < after.period_ns / 4;
  if (holds) {
    after.period_ns += (interval - after.period_ns) / 8;
    after.steadiness = std::min(after.steadiness + 1, steadiest);
    return;
  }
  after.steadiness = std::max(after.steadiness - 2, 0);
  if (after.steadiness == 0 && interval > 0) after.period_ns = interval;
}

Status Acquisition::judge_time(CameraFrame& taken, TimeNs now, TimeDoubt& doubt, Outcome& outcome) const {
  State& after = outcome.after;
  doubt = TimeDoubt::none;
  const TimeNs stamp = taken.time_ns;
  // A camera that selects from its own exposures reports their times itself.
  const bool commanded = camera_.triggered() && camera_.granularity() == 0 && !unasked_ && !after.pending.empty();
  if (commanded) {
    TimeNs nearest = after.pending[0].time_ns;
    for (const Pending& wanted : after.pending) {
      if (wanted.time_ns <= now && distance(stamp, wanted.time_ns) < distance(stamp, nearest)) nearest = wanted.time_ns;
    }
    if (distance(stamp, nearest) > trigger_tolerance_ns) {
      doubt = TimeDoubt::off_command;
      taken.time_ns = nearest;
    }
  } else if (!camera_.triggered() && state_.any) {
    const std::int64_t exposures = std::max<std::int64_t>(taken.sequence - state_.last_sequence, 1);
    // A counter that runs ahead of time is not evidence of lost frames.
    const TimeNs passed = now - state_.last_time_ns + state_.period_ns / 2 + clock_tolerance_ns;
    const bool possible = state_.period_ns > 0 && exposures <= passed / state_.period_ns;
    const bool believed = state_.steadiness >= steady && possible;
    const TimeNs expected = state_.last_time_ns + (possible ? exposures * state_.period_ns : 0);
    if (believed && distance(stamp, expected) > state_.period_ns / 2) {
      doubt = TimeDoubt::off_period;
      taken.time_ns = expected;
    }
    learn_period(stamp - state_.last_time_ns, exposures, after);
  }
  // If it were accepted, every later frame would seem to come from the past.
  if (taken.time_ns > now + clock_tolerance_ns) return {StatusCode::time_ahead, taken.sequence, taken.time_ns - now};
  if (state_.any && taken.time_ns <= state_.last_time_ns) {
    return {StatusCode::time_not_monotonic, taken.sequence, state_.last_time_ns - taken.time_ns};
  }
  after.last_time_ns = taken.time_ns;
  if (doubt != TimeDoubt::none) {
    outcome.event = {StatusCode::frame_mis_stamped, taken.sequence, (stamp - taken.time_ns) / 1000};
  } else if (now - stamp > late_ns + camera_.granularity()) {
    outcome.event = {StatusCode::frame_late, taken.sequence, (now - stamp) / 1000};
  }
  return {};
}

void Acquisition::keep(const CameraFrame& taken, TimeDoubt doubt, std::int64_t capture_id, Outcome& outcome) const {
  FrameRecord& frame = outcome.frame;
  outcome.has_frame = true;
  frame.id = ++outcome.cursor.first;
  frame.time_ns = taken.time_ns;
  frame.sequence = taken.sequence;
  frame.width = image_.width();
  frame.height = image_.height();
  frame.altitude = taken.altitude;
  frame.capture_id = capture_id;
  frame.time_doubt = doubt;
  std::memcpy(frame.name, taken.name, sizeof(frame.name));
  frame.name[sizeof(frame.name) - 1] = 0;
  frame.image.bytes = static_cast<std::uint32_t>(image_.view().area());
  outcome.after.any_kept = true;
}

Status Acquisition::choose_capture(const CameraFrame& taken, TimeDoubt doubt, Outcome& outcome) {
  State& after = outcome.after;
  const bool free = !camera_.triggered();
  const TimeNs period = state_.period_ns > 0 ? state_.period_ns : ns_from_seconds(mission_.capture_timeout_s);
  // The next frame of a free camera comes a period later and may be the nearer one.
  const TimeNs early = free ? state_.period_ns / 2 : trigger_tolerance();
  const TimeNs late = free ? period : trigger_tolerance();
  while (!after.pending.empty()) {
    std::size_t best = 0;
    for (std::size_t i = 1; i < after.pending.size(); ++i) {
      if (distance(taken.time_ns, after.pending[i].time_ns) < distance(taken.time_ns, after.pending[best].time_ns)) {
        best = i;
      }
    }
    const Pending wanted = after.pending[best];
    if (taken.time_ns + early < wanted.time_ns) return {};
    CaptureRecord capture;
    const Status found = get(store_, wanted.id, capture);
    if (is_transient(found)) return found;
    const bool commanded = found.ok() && capture.source == CaptureSource::telecommand;
    if (!commanded && taken.time_ns > wanted.time_ns + late) return {};
    remove_pending(best, after);
    if (!found.ok() || capture.state != CaptureState::pending) continue;  // superseded
    const TimeNs off = distance(taken.time_ns, wanted.time_ns);
    capture.exposed_ns = taken.time_ns;
    outcome.has_capture = true;
    if (commanded && off > grain()) {
      // No nearer frame will come. The image is not the requested one, and counts as a failure.
      capture.state = CaptureState::no_frame;
      outcome.event = {StatusCode::capture_off_time, capture.id, off / ns_per_us};
      capture.reason = static_cast<std::uint16_t>(outcome.event.code);
      outcome.capture = capture;
      return {};
    }
    keep(taken, doubt, wanted.id, outcome);
    capture.state = CaptureState::exposed;
    capture.frame_id = outcome.frame.id;
    outcome.capture = capture;
    return {};
  }
  return {};
}

Status Acquisition::take(CameraFrame& taken, TimeNs now, Outcome& outcome) {
  ILP_ASSERT(image_.width() > 0 && image_.height() > 0, taken.sequence);
  bool repeated = false;
  ILP_TRY(find_repetition(taken, outcome, repeated));
  if (repeated) return {};
  State& after = outcome.after;
  after.last_sequence = taken.sequence;
  after.any = true;
  TimeDoubt doubt = TimeDoubt::none;
  const Status in_time = judge_time(taken, now, doubt, outcome);
  if (!in_time.ok()) {
    outcome.event = in_time;
    return {};
  }
  const std::int64_t missing = taken.sequence - std::max(state_.last_sequence, seen_sequence_) - 1;
  if (state_.any && missing > 0) outcome.event = {StatusCode::frame_gap, taken.sequence, missing};
  const bool by_lock = locked_ns_ >= 0 && unlocked_ns_ >= state_.last_time_ns && every_frame();
  if (state_.any && missing > 0 && by_lock) {
    outcome.event = {StatusCode::images_lost, missing, (unlocked_ns_ - locked_ns_) / ns_per_ms};
  }
  // A camera that runs freely shows the first frame unasked: it tells the period and begins the regular interval.
  const bool first = !camera_.triggered() && !after.any_kept && mission_.capture_mode != CaptureMode::telecommanded;
  if (!first || every_frame()) ILP_TRY(choose_capture(taken, doubt, outcome));
  if ((first || every_frame()) && !outcome.has_frame) keep(taken, doubt, 0, outcome);
  return {};
}

Status Acquisition::end_of_stream() {
  State after = state_;
  after.ended = true;
  CommandRecord command;
  command.time_ns = clock_.now();
  command.kind = CommandKind::end_strip;
  command.reason = StripEnd::end_of_flight;
  command.after_frame_id = cursor_.first;
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_new_command(store_, command));
  ILP_TRY(transaction.commit(cursor_, after, cursor_, state_));
  return {StatusCode::flight_ended, cursor_.first};
}

Status Acquisition::write(const Outcome& outcome) {
  const Status written = write_all(outcome);
  if (written.is(StatusCode::store_locked)) {
    if (locked_ns_ < 0 || unlocked_ns_ >= 0) locked_ns_ = clock_.now();
    unlocked_ns_ = -1;
  } else if (locked_ns_ >= 0 && unlocked_ns_ < 0) {
    unlocked_ns_ = clock_.now();
  }
  return written;
}

void Acquisition::count_lost(Outcome& outcome) {
  const std::int64_t lost = images_missed(mission_, taken_.time_ns, unlocked_ns_);
  if (lost == 0) return;
  Status& event = outcome.event.ok() ? outcome.event : next_event_;
  event = {StatusCode::images_lost, lost, (unlocked_ns_ - locked_ns_) / ns_per_ms};
}

Status Acquisition::write_all(const Outcome& outcome) {
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  if (outcome.has_frame) {
    const GrayView pixels = image_.view();
    ILP_TRY(put(store_, outcome.frame));
    ILP_TRY(write_blob<FrameRecord>(store_, "image", outcome.frame.id, 0, {pixels.data, pixels.area()}));
  }
  if (outcome.has_capture) ILP_TRY(amend(store_, outcome.capture));
  return transaction.commit(outcome.cursor, outcome.after, cursor_, state_);
}

Status Acquisition::listen(TimeNs now) {
  if (heard_ns_ < 0) heard_ns_ = now;
  if (camera_.triggered() || silent_) return {};
  const TimeNs shortest = state_.period_ns == 0 ? unknown_silence_ns : shortest_silence_ns;
  const TimeNs silence = now - heard_ns_;
  if (silence < std::max(periods_until_silent * state_.period_ns, shortest)) return {};
  silent_ = true;
  return {StatusCode::camera_silent, state_.last_sequence, silence / ns_per_ms};
}

bool Acquisition::every_frame() const {
  return !mission_.safe_mode && mission_.capture_mode == CaptureMode::regular && mission_.capture_interval_s <= 0;
}

TimeNs Acquisition::trigger_tolerance() const {
  return std::max(trigger_tolerance_ns, camera_.granularity());
}

TimeNs Acquisition::grain() const {
  // The nearest frame of a camera that runs freely, with a quarter of that for its unsteadiness.
  return camera_.triggered() ? trigger_tolerance() : std::max(trigger_tolerance_ns, state_.period_ns / 8 * 5);
}

Status Acquisition::trigger(TimeNs now) {
  if (!camera_.triggered()) return {};
  const TimeNs grain = camera_.granularity();
  const bool soon = !state_.pending.empty() && state_.pending[0].time_ns - now < trigger_lead_ns;
  unasked_ = every_frame() && camera_.exposes_unasked() && (grain > 0 || !soon);
  if (unasked_) return camera_.trigger(Camera::any_time);
  for (const Pending& wanted : state_.pending) {
    // If such a camera has shown no frame by now it will show none, and the captures after it need not wait.
    if (grain > 0 && now - wanted.time_ns > grain + late_ns) continue;
    return camera_.trigger(wanted.time_ns);
  }
  return {};
}

double Acquisition::ground_speed_px_s() const {
  OverlapRecord overlap;
  if (!last(store_, overlap).ok() || overlap.verdict != OverlapVerdict::ok || overlap.keyframe_id == 0) return 0;
  KeyframeRecord keyframe;
  FrameRecord first, second;
  if (!get(store_, overlap.keyframe_id, keyframe).ok() || !get(store_, keyframe.frame_id, first).ok() ||
      !get(store_, overlap.id, second).ok() || second.time_ns <= first.time_ns) {
    return 0;
  }
  const double half_width = 0.5 * second.width, half_height = 0.5 * second.height;
  const double corner = std::sqrt(half_width * half_width + half_height * half_height);
  const double shift = std::sqrt(overlap.shift_x_px * overlap.shift_x_px + overlap.shift_y_px * overlap.shift_y_px);
  const double moved = shift + corner * (std::fabs(overlap.rotation_rad) + std::fabs(overlap.scale - 1));
  return moved * static_cast<double>(ns_per_s) / static_cast<double>(second.time_ns - first.time_ns);
}

bool Acquisition::begin_exposure_control() {
  ExposureRange range;
  const Status known = camera_.exposure_range(range);
  if (known.is(StatusCode::not_ready)) return false;
  if (known.ok()) {
    exposure_.begin(range);
    return true;
  }
  exposure_.give_up();
  next_event_ = {StatusCode::exposure_unsupported, static_cast<std::int64_t>(known.code), known.a};
  return false;
}

void Acquisition::control_exposure() {
  if (!mission_.exposure_control) {
    if (exposure_.begun()) exposure_.reset();
    return;
  }
  if (exposure_.given_up() || (!exposure_.begun() && !begin_exposure_control())) return;
  speed_px_s_ = std::max(ground_speed_px_s(), speed_px_s_ * (1 - speed_fading));
  ExposureGoal goal;
  goal.bright_grey = mission_.exposure_bright_grey;
  goal.longest_us = longest_exposure_us(mission_.exposure_blur_px, speed_px_s_, mission_.exposure_longest_us);
  goal.most_gain_milli = static_cast<std::int64_t>(1000 * mission_.exposure_most_gain);
  ExposureSetting next;
  const auto answer = exposure_.look_at(measure_brightness(image_.view()), taken_.exposure, goal, next, next_event_);
  if (answer == ExposureControl::Answer::keep) return;
  const Status set = camera_.set_exposure(next);
  if (set.is(StatusCode::not_ready)) return;
  if (!set.ok()) {
    exposure_.give_up();
    next_event_ = {StatusCode::exposure_unsupported, static_cast<std::int64_t>(set.code), set.a};
    return;
  }
  exposure_.asked(next);
  if (next_event_.ok()) next_event_ = {StatusCode::exposure_changed, next.exposure_us, next.gain_milli};
}

StepResult Acquisition::step() {
  if (state_.ended) return {};
  if (!next_event_.ok()) {
    const Status event = next_event_;
    next_event_ = {};
    return {event, true};
  }
  Outcome outcome;
  outcome.after = state_;
  outcome.cursor = cursor_;
  bool changed = false;
  Status status = learn_captures(outcome, changed);
  // The frame at hand may be the answer.
  if (status.ok() && !held_) status = give_up_captures(outcome, changed);
  if (!status.ok()) return {status, false};
  Status waiting;
  if (changed) {
    waiting = write(outcome);
    // An image that comes meanwhile is held.
    if (!waiting.is(StatusCode::store_locked) || held_) return {waiting.ok() ? outcome.event : waiting, true};
  }
  if (held_) return store_taken();
  const TimeNs now = clock_.now();
  const Status triggered = trigger(now);
  if (!triggered.ok()) return {triggered, false};
  status = camera_.capture(now, image_, taken_);
  taken_ns_ = now;
  if (status.is(StatusCode::not_ready)) {
    const Status silent = listen(now);
    return {silent.ok() ? waiting : silent, false};
  }
  if (status.is(StatusCode::end_of_stream)) return {end_of_stream(), false};
  heard_ns_ = now;
  silent_ = false;
  // After a restart the source may begin again with frames that are already stored.
  if (state_.any && taken_.sequence <= restored_sequence_ && (status.ok() || taken_.sequence > 0)) return {{}, true};
  if (!status.ok()) return {status, true};
  control_exposure();
  return store_taken();
}

StepResult Acquisition::store_taken() {
  Outcome outcome;
  outcome.after = state_;
  outcome.cursor = cursor_;
  CameraFrame taken = taken_;
  Status status = take(taken, taken_ns_, outcome);
  if (status.ok()) status = write(outcome);
  // The camera is not asked while a frame is held.
  if (held_) heard_ns_ = clock_.now();
  const bool locked = status.is(StatusCode::store_locked);
  if (locked && !outcome.has_frame && !outcome.has_capture) {
    // It is not worth the place of one that is wanted.
    seen_sequence_ = std::max(seen_sequence_, taken_.sequence);
    held_ = false;
    return {outcome.event.ok() ? status : outcome.event, false};
  }
  if (status.ok() && held_by_lock_) count_lost(outcome);
  held_by_lock_ = locked || (held_by_lock_ && !status.ok());
  // An older frame is dropped for the next one, which is worth as much.
  held_ = is_transient(status) && clock_.now() - taken_ns_ < longest_hold_ns;
  return {status.ok() ? outcome.event : status, !held_};
}

}  // namespace ilp
