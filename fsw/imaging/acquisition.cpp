#include "fsw/imaging/acquisition.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "fsw/base/crc.hpp"
#include "fsw/imaging/apparent_speed.hpp"
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

TimeNs trigger_tolerance(const Camera& camera) {
  return std::max(trigger_tolerance_ns, camera.granularity());
}

bool is_uniform(GrayView image) {
  for (std::int32_t y = 0; y < image.height; ++y) {
    for (std::int32_t x = 0; x < image.width; ++x) {
      if (image.row(y)[x] != image.row(0)[0]) return false;
    }
  }
  return true;
}

/// Of the ground in the newest images: px/s, 0 when it is not known.
double ground_speed_px_s(Reader<OverlapRecord, KeyframeRecord, FrameRecord> store) {
  OverlapRecord overlap;
  if (!last(store, overlap).ok() || overlap.verdict != OverlapVerdict::ok || overlap.keyframe_id == 0) return 0;
  KeyframeRecord keyframe;
  FrameRecord first, second;
  if (!get(store, overlap.keyframe_id, keyframe).ok() || !get(store, keyframe.frame_id, first).ok() ||
      !get(store, overlap.id, second).ok() || second.time_ns <= first.time_ns) {
    return 0;
  }
  const Similarity2 moved{overlap.scale, overlap.rotation_rad, overlap.shift_x_px, overlap.shift_y_px};
  return apparent_speed_px_s(moved, second.width, second.height, second.time_ns - first.time_ns);
}

}  // namespace

constexpr CheckpointForm Acquisition::checkpoint = checkpoint_form<State>(component_id);

Acquisition::Acquisition(Tables store, Camera& camera, Clock& clock, const MissionParameters& mission)
    : wiring_{store, camera, clock, mission} {}

Status Acquisition::restore() {
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  begin_ids<FrameRecord>(wiring_.store, cursor_.first);
  ILP_TRY(resume_after_records());
  // Counter and period of a previous boot are not valid for this one.
  if (wiring_.camera.restarts_counter()) {
    state_.any = false;
    state_.last_sequence = -1;
  }
  work_ = {.restored_sequence = state_.last_sequence, .frame = work_.frame};
  return status;
}

Status Acquisition::resume_after_records() {
  FrameRecord newest;
  ILP_TAKE(const bool found, found_by(last(wiring_.store, newest)));
  const std::int64_t known = cursor_.first;
  ILP_TRY(newest_id<FrameRecord>(wiring_.store, newest.id));
  cursor_.first = std::max(known, newest.id);
  if (!found || cursor_.first == known) return {};
  state_.last_sequence = newest.sequence;
  state_.last_time_ns = newest.time_ns;
  state_.any = true;
  state_.any_kept = true;
  return {};
}

Result<bool> Acquisition::learn_captures(Outcome& outcome) const {
  State& after = outcome.after;
  bool changed = false;
  // Bounded by the capacity: further captures wait.
  while (!after.pending.full()) {
    CaptureRecord capture;
    ILP_TAKE(const Found found, find_next(wiring_.store, outcome.cursor.second, capture));
    if (found == Found::nothing) break;
    changed = true;
    outcome.cursor.second = capture.id;
    const bool damaged = found == Found::damaged;
    if (damaged) outcome.event = {StatusCode::record_damaged, capture.id, static_cast<int>(RecordType::capture)};
    if (damaged || capture.state != CaptureState::pending) continue;
    static_cast<void>(after.pending.push_back({capture.id, capture.requested_ns}));
    for (std::size_t i = after.pending.size() - 1; i > 0 && after.pending[i].time_ns < after.pending[i - 1].time_ns;
         --i)
      std::swap(after.pending[i], after.pending[i - 1]);
  }
  return changed;
}

Result<bool> Acquisition::abandon_captures(Outcome& outcome) const {
  State& after = outcome.after;
  if (after.pending.empty()) return false;
  const Pending first = after.pending[0];
  const TimeNs timeout = ns_from_seconds(wiring_.mission.capture_timeout_s);
  CaptureRecord capture;
  ILP_TAKE(const bool found, find(wiring_.store, first.id, capture));
  // No request waits for a capture that no longer exists.
  const bool superseded = !found || capture.state != CaptureState::pending;
  if (!superseded && wiring_.clock.now() - first.time_ns <= timeout) return false;
  after.pending.erase(0);
  if (superseded) return true;
  capture.state = CaptureState::no_frame;
  outcome.capture = capture;
  outcome.has_capture = true;
  if (capture.source != CaptureSource::burst)
    outcome.event = {StatusCode::capture_missed, first.id, timeout / ns_per_ms};
  return true;
}

bool Acquisition::repeats(const CameraFrame& taken, Outcome& outcome) const {
  if (state_.any && taken.sequence <= state_.last_sequence) {
    const bool again = taken.sequence == state_.last_sequence;
    outcome.event = {again ? StatusCode::frame_duplicated : StatusCode::frame_out_of_order, taken.sequence,
                     state_.last_sequence};
    return true;
  }
  const GrayView pixels = workspace_.image.view();
  const std::uint32_t crc = crc32({pixels.data, pixels.area()});
  outcome.after.last_crc32 = crc;
  // A sensor's noise never repeats: the same bytes are the same exposure, unless all pixels are black or saturated.
  const bool repeated = state_.any && crc == state_.last_crc32 && !is_uniform(pixels);
  if (repeated) outcome.event = {StatusCode::frame_duplicated, taken.sequence, state_.last_sequence};
  return repeated;
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

Result<TimeDoubt> Acquisition::judge_time(CameraFrame& taken, TimeNs now, Outcome& outcome) const {
  State& after = outcome.after;
  TimeDoubt suspicion = TimeDoubt::none;
  const TimeNs stamp = taken.time_ns;
  // A camera that selects from its own exposures reports their times itself.
  const bool commanded =
      wiring_.camera.triggered() && wiring_.camera.granularity() == 0 && !work_.frame.unasked && !after.pending.empty();
  if (commanded) {
    TimeNs nearest = after.pending[0].time_ns;
    for (const Pending& wanted : after.pending) {
      if (wanted.time_ns <= now && distance(stamp, wanted.time_ns) < distance(stamp, nearest)) nearest = wanted.time_ns;
    }
    if (distance(stamp, nearest) > trigger_tolerance_ns) {
      suspicion = TimeDoubt::off_command;
      taken.time_ns = nearest;
    }
  } else if (!wiring_.camera.triggered() && state_.any) {
    const std::int64_t exposures = std::max<std::int64_t>(taken.sequence - state_.last_sequence, 1);
    // A counter that runs ahead of time is not evidence of lost frames.
    const TimeNs passed = now - state_.last_time_ns + state_.period_ns / 2 + clock_tolerance_ns;
    const bool possible = state_.period_ns > 0 && exposures <= passed / state_.period_ns;
    const bool believed = state_.steadiness >= steady && possible;
    const TimeNs expected = state_.last_time_ns + (possible ? exposures * state_.period_ns : 0);
    if (believed && distance(stamp, expected) > state_.period_ns / 2) {
      suspicion = TimeDoubt::off_period;
      taken.time_ns = expected;
    }
    learn_period(stamp - state_.last_time_ns, exposures, after);
  }
  // If it were accepted, every later frame would seem to come from the past.
  const TimeNs ahead = taken.time_ns - now, back = state_.last_time_ns - taken.time_ns;
  if (ahead > clock_tolerance_ns) return Status{StatusCode::time_ahead, taken.sequence, ahead};
  if (state_.any && back >= 0) return Status{StatusCode::time_not_monotonic, taken.sequence, back};
  after.last_time_ns = taken.time_ns;
  if (suspicion != TimeDoubt::none) {
    outcome.event = {StatusCode::frame_mis_stamped, taken.sequence, (stamp - taken.time_ns) / 1000};
  } else if (now - stamp > late_ns + wiring_.camera.granularity()) {
    outcome.event = {StatusCode::frame_late, taken.sequence, (now - stamp) / 1000};
  }
  return suspicion;
}

void Acquisition::keep(const CameraFrame& taken, TimeDoubt suspicion, std::int64_t capture_id, Outcome& outcome) const {
  FrameRecord& frame = outcome.frame;
  outcome.has_frame = true;
  frame.id = ++outcome.cursor.first;
  frame.time_ns = taken.time_ns;
  frame.sequence = taken.sequence;
  frame.width = workspace_.image.width();
  frame.height = workspace_.image.height();
  frame.altitude = taken.altitude;
  frame.capture_id = capture_id;
  frame.time_doubt = suspicion;
  frame.exposure_us =
      taken.exposure.known() ? taken.exposure.exposure_us : std::llround(1e6 * wiring_.mission.exposure_known_s);
  std::memcpy(frame.name, taken.name, sizeof(frame.name));
  frame.name[sizeof(frame.name) - 1] = 0;
  frame.image.bytes = static_cast<std::uint32_t>(workspace_.image.view().area());
  outcome.after.any_kept = true;
}

Status Acquisition::choose_capture(const CameraFrame& taken, TimeDoubt suspicion, Outcome& outcome) {
  State& after = outcome.after;
  const bool free = !wiring_.camera.triggered();
  const TimeNs period = state_.period_ns > 0 ? state_.period_ns : ns_from_seconds(wiring_.mission.capture_timeout_s);
  // The next frame of a free camera comes a period later and may be the nearer one.
  const TimeNs early = free ? state_.period_ns / 2 : trigger_tolerance(wiring_.camera);
  const TimeNs late = free ? period : trigger_tolerance(wiring_.camera);
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
    ILP_TAKE(const bool found, find(wiring_.store, wanted.id, capture));
    const bool commanded = found && capture.source == CaptureSource::telecommand;
    if (!commanded && taken.time_ns > wanted.time_ns + late) return {};
    after.pending.erase(best);
    if (!found || capture.state != CaptureState::pending) continue;  // superseded
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
    keep(taken, suspicion, wanted.id, outcome);
    capture.state = CaptureState::exposed;
    capture.frame_id = outcome.frame.id;
    outcome.capture = capture;
    return {};
  }
  return {};
}

Status Acquisition::take(CameraFrame& taken, TimeNs now, Outcome& outcome) {
  ILP_ASSERT(workspace_.image.width() > 0 && workspace_.image.height() > 0, taken.sequence);
  if (repeats(taken, outcome)) return {};
  State& after = outcome.after;
  after.last_sequence = taken.sequence;
  after.any = true;
  const Result<TimeDoubt> suspicion = judge_time(taken, now, outcome);
  if (!suspicion.ok()) {
    outcome.event = suspicion.status();
    return {};
  }
  const std::int64_t missing = taken.sequence - std::max(state_.last_sequence, work_.seen_sequence) - 1;
  const LockTimes& lock = work_.lock;
  const bool by_lock = lock.is == LockTimes::Is::free_again && lock.end_ns >= state_.last_time_ns && every_frame();
  if (state_.any && missing > 0) {
    outcome.event = by_lock ? Status{StatusCode::images_lost, missing, (lock.end_ns - lock.begin_ns) / ns_per_ms}
                            : Status{StatusCode::frame_gap, taken.sequence, missing};
  }
  // A camera that runs freely shows the first frame unasked: it tells the period and begins the regular interval.
  const bool first =
      !wiring_.camera.triggered() && !after.any_kept && wiring_.mission.capture_mode != CaptureMode::telecommanded;
  if (!first || every_frame()) ILP_TRY(choose_capture(taken, suspicion.value(), outcome));
  if ((first || every_frame()) && !outcome.has_frame) keep(taken, suspicion.value(), 0, outcome);
  return {};
}

Status Acquisition::end_of_stream() {
  State after = state_;
  after.ended = true;
  CommandRecord command{.time_ns = wiring_.clock.now(),
                        .kind = CommandKind::end_strip,
                        .reason = StripEnd::end_of_flight,
                        .after_frame_id = cursor_.first};
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_new_command(wiring_.store, command));
  ILP_TRY(transaction.commit(cursor_, after, cursor_, state_));
  return {StatusCode::flight_ended, cursor_.first};
}

Status Acquisition::write(Outcome& outcome) {
  const Status written = write_all(outcome);
  work_.lock.note(written.is(StatusCode::store_locked), wiring_.clock.now());
  return written;
}

void Acquisition::count_lost(Outcome& outcome) {
  const std::int64_t lost = images_missed(wiring_.mission, work_.frame.taken.time_ns, work_.lock.end_ns);
  if (lost == 0) return;
  Status& event = outcome.event.ok() ? outcome.event : work_.next_event;
  event = {StatusCode::images_lost, lost, (work_.lock.end_ns - work_.lock.begin_ns) / ns_per_ms};
}

Status Acquisition::write_all(Outcome& outcome) {
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (outcome.has_frame) {
    const GrayView pixels = workspace_.image.view();
    ILP_TRY(put(wiring_.store, outcome.frame));
    ILP_TRY(write_blob<FrameRecord>(wiring_.store, "image", outcome.frame.id, 0, {pixels.data, pixels.area()}));
  }
  if (outcome.has_capture) ILP_TRY(amend(wiring_.store, outcome.capture));
  return transaction.commit(outcome.cursor, outcome.after, cursor_, state_);
}

Status Acquisition::listen(TimeNs now) {
  if (!work_.asked) work_.received_ns = now;
  work_.asked = true;
  if (wiring_.camera.triggered() || work_.silent) return {};
  const TimeNs shortest = state_.period_ns == 0 ? unknown_silence_ns : shortest_silence_ns;
  const TimeNs silence = now - work_.received_ns;
  if (silence < std::max(periods_until_silent * state_.period_ns, shortest)) return {};
  work_.silent = true;
  return {StatusCode::camera_silent, state_.last_sequence, silence / ns_per_ms};
}

bool Acquisition::every_frame() const {
  return !wiring_.mission.safe_mode && wiring_.mission.capture_mode == CaptureMode::regular &&
         wiring_.mission.capture_interval_s <= 0;
}

TimeNs Acquisition::grain() const {
  // The nearest frame of a camera that runs freely, with a quarter of that for its unsteadiness.
  return wiring_.camera.triggered() ? trigger_tolerance(wiring_.camera)
                                    : std::max(trigger_tolerance_ns, state_.period_ns / 8 * 5);
}

Status Acquisition::trigger(TimeNs now) {
  if (!wiring_.camera.triggered()) return {};
  const TimeNs grain = wiring_.camera.granularity();
  const bool soon = !state_.pending.empty() && state_.pending[0].time_ns - now < trigger_lead_ns;
  work_.frame.unasked = every_frame() && wiring_.camera.exposes_unasked() && (grain > 0 || !soon);
  if (work_.frame.unasked) return wiring_.camera.trigger(Camera::any_time);
  for (const Pending& wanted : state_.pending) {
    // If such a camera has shown no frame by now it will show none, and the captures after it need not wait.
    if (grain > 0 && now - wanted.time_ns > grain + late_ns) continue;
    return wiring_.camera.trigger(wanted.time_ns);
  }
  return {};
}

bool Acquisition::begin_exposure_control() {
  ExposureRange range;
  const Status known = wiring_.camera.exposure_range(range);
  if (known.is(StatusCode::not_ready)) return false;
  if (known.ok()) {
    work_.exposure.begin(range);
    return true;
  }
  work_.exposure.abandon();
  work_.next_event = {StatusCode::exposure_unsupported, static_cast<std::int64_t>(known.code), known.a};
  return false;
}

void Acquisition::control_exposure() {
  if (!wiring_.mission.exposure_control) {
    if (work_.exposure.begun()) work_.exposure.reset();
    return;
  }
  if (work_.exposure.abandoned() || (!work_.exposure.begun() && !begin_exposure_control())) return;
  work_.speed_px_s = std::max(ground_speed_px_s(wiring_.store), work_.speed_px_s * (1 - speed_fading));
  ExposureGoal goal;
  goal.bright_grey = wiring_.mission.exposure_bright_grey;
  goal.longest_us =
      longest_exposure_us(wiring_.mission.exposure_blur_px, work_.speed_px_s, wiring_.mission.exposure_longest_us);
  goal.most_gain_milli = static_cast<std::int64_t>(1000 * wiring_.mission.exposure_most_gain);
  ExposureSetting next;
  const auto answer = work_.exposure.evaluate(measure_brightness(workspace_.image.view()), work_.frame.taken.exposure,
                                              goal, next, work_.next_event);
  if (answer == ExposureControl::Answer::keep) return;
  const Status set = wiring_.camera.set_exposure(next);
  if (set.is(StatusCode::not_ready)) return;
  if (!set.ok()) {
    work_.exposure.abandon();
    work_.next_event = {StatusCode::exposure_unsupported, static_cast<std::int64_t>(set.code), set.a};
    return;
  }
  work_.exposure.asked(next);
  if (work_.next_event.ok()) work_.next_event = {StatusCode::exposure_changed, next.exposure_us, next.gain_milli};
}

StepResult Acquisition::step() {
  if (state_.ended) return {};
  if (!work_.next_event.ok()) {
    const Status event = work_.next_event;
    work_.next_event = {};
    return {event, true};
  }
  Outcome outcome{.after = state_, .cursor = cursor_};
  const Result<bool> learned = learn_captures(outcome);
  if (!learned.ok()) return {learned.status(), false};
  // The frame at hand may be the answer.
  const Result<bool> abandoned = work_.frame.held ? Result<bool>(false) : abandon_captures(outcome);
  if (!abandoned.ok()) return {abandoned.status(), false};
  Status waiting;
  if (learned.value() || abandoned.value()) {
    waiting = write(outcome);
    // An image that comes meanwhile is held.
    if (!waiting.is(StatusCode::store_locked) || work_.frame.held)
      return {waiting.ok() ? outcome.event : waiting, true};
  }
  if (work_.frame.held) return store_taken();
  const TimeNs now = wiring_.clock.now();
  const Status triggered = trigger(now);
  if (!triggered.ok()) return {triggered, false};
  const Status status = wiring_.camera.capture(now, workspace_.image, work_.frame.taken);
  work_.frame.taken_ns = now;
  if (status.is(StatusCode::not_ready)) {
    const Status silent = listen(now);
    return {silent.ok() ? waiting : silent, false};
  }
  if (status.is(StatusCode::end_of_stream)) return {end_of_stream(), false};
  work_.received_ns = now;
  work_.asked = true;
  work_.silent = false;
  // After a restart the source may begin again with frames that are already stored.
  if (state_.any && work_.frame.taken.sequence <= work_.restored_sequence &&
      (status.ok() || work_.frame.taken.sequence > 0))
    return {{}, true};
  if (!status.ok()) return {status, true};
  control_exposure();
  return store_taken();
}

StepResult Acquisition::store_taken() {
  Outcome outcome{.after = state_, .cursor = cursor_};
  CameraFrame taken = work_.frame.taken;
  Status status = take(taken, work_.frame.taken_ns, outcome);
  if (status.ok()) status = write(outcome);
  // The camera is not asked while a frame is held.
  if (work_.frame.held) work_.received_ns = wiring_.clock.now();
  work_.asked = true;
  const bool locked = status.is(StatusCode::store_locked);
  if (locked && !outcome.has_frame && !outcome.has_capture) {
    // It is not worth the place of one that is wanted.
    work_.seen_sequence = std::max(work_.seen_sequence, work_.frame.taken.sequence);
    work_.frame.held = false;
    return {outcome.event.ok() ? status : outcome.event, false};
  }
  if (status.ok() && work_.held_by_lock) count_lost(outcome);
  work_.held_by_lock = locked || (work_.held_by_lock && !status.ok());
  // An older frame is dropped for the next one, which is worth as much.
  work_.frame.held = is_transient(status) && wiring_.clock.now() - work_.frame.taken_ns < longest_hold_ns;
  return {status.ok() ? outcome.event : status, !work_.frame.held};
}

}  // namespace ilp
