#include "fsw/components/acquisition.hpp"

#include <cstring>

namespace ilp {
namespace {
constexpr std::uint32_t layout = 1;
// Cameras and board share a clock to better than this, or the stamps are of no use.
constexpr TimeNs clock_tolerance_ns = 100 * ns_per_ms;
// A camera is silent after so many of its intervals, and not before the shortest time.
constexpr TimeNs frames_until_silent = 5;
constexpr TimeNs shortest_silence_ns = 10 * ns_per_s;
constexpr TimeNs unknown_silence_ns = 60 * ns_per_s;
}  // namespace

Acquisition::Acquisition(Store& store, Camera& camera, Clock& clock, const MissionParameters& mission)
    : store_(store), camera_(camera), clock_(clock), mission_(mission) {}

Status Acquisition::restore() {
  cursor_ = {};
  state_ = {};
  const Status status = load_checkpoint(store_, ComponentId::acquisition, cursor_, layout, state_);
  restored_sequence_ = state_.last_sequence;
  newest_sequence_ = state_.last_sequence;
  left_out_ = 0;
  return status.is(StatusCode::not_found) ? Status{} : status;
}

Status Acquisition::keep(const CameraFrame& taken) {
  State after = state_;
  after.last_sequence = taken.sequence;
  after.last_time_ns = taken.time_ns;
  after.any = true;

  FrameRecord frame;
  frame.id = cursor_.first + 1;
  frame.time_ns = taken.time_ns;
  frame.sequence = taken.sequence;
  frame.width = image_.width();
  frame.height = image_.height();
  frame.altitude = taken.altitude;
  std::memcpy(frame.name, taken.name, sizeof(frame.name));
  frame.name[sizeof(frame.name) - 1] = 0;
  const GrayView pixels = image_.view();
  frame.image.bytes = static_cast<std::uint32_t>(pixels.area());

  const Cursor next{frame.id, cursor_.second};
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, frame));
  ILP_TRY(write_blob<FrameRecord>(store_, "image", frame.id, 0, {pixels.data, pixels.area()}));
  ILP_TRY(save_checkpoint(store_, ComponentId::acquisition, next, layout, after));
  ILP_TRY(transaction.commit());
  cursor_ = next;
  state_ = after;
  return {};
}

Status Acquisition::end_of_stream() {
  State after = state_;
  after.ended = true;
  CommandRecord previous;
  const Status found = last(store_, previous);
  CommandRecord command;
  command.id = found.ok() ? previous.id + 1 : 1;
  command.time_ns = clock_.now();
  command.kind = CommandKind::end_strip;
  command.reason = StripEnd::end_of_flight;
  command.after_frame_id = cursor_.first;
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, command));
  ILP_TRY(save_checkpoint(store_, ComponentId::acquisition, cursor_, layout, after));
  ILP_TRY(transaction.commit());
  state_ = after;
  return {StatusCode::flight_ended, cursor_.first};
}

Status Acquisition::refuse(const CameraFrame& taken, const Status& why) {
  if (taken.sequence > newest_sequence_) newest_sequence_ = taken.sequence;
  if (taken.sequence > state_.last_sequence) ++left_out_;
  return why;
}

Status Acquisition::check_stamp(const CameraFrame& taken, TimeNs now) const {
  // Once accepted, it would make every later frame look as if it came from the past.
  if (taken.time_ns > now + clock_tolerance_ns) return {StatusCode::time_ahead, taken.sequence, taken.time_ns - now};
  const TimeNs since_last = taken.time_ns - state_.last_time_ns;
  if (state_.any && since_last <= 0) return {StatusCode::time_not_monotonic, taken.sequence, -since_last};
  return {};
}

Status Acquisition::listen(TimeNs now) {
  if (heard_ns_ < 0) heard_ns_ = now;
  const TimeNs usual = frames_until_silent * interval_ns_;
  const TimeNs shortest = interval_ns_ == 0 ? unknown_silence_ns : shortest_silence_ns;
  const TimeNs silence = now - heard_ns_;
  if (silent_ || silence < (usual > shortest ? usual : shortest)) return {};
  silent_ = true;
  return {StatusCode::camera_silent, newest_sequence_, silence / ns_per_ms};
}

StepResult Acquisition::step(TimeNs deadline) {
  static_cast<void>(deadline);
  if (state_.ended) return {};
  const TimeNs now = clock_.now();
  CameraFrame taken;
  const Status status = camera_.capture(now, image_, taken);
  if (status.is(StatusCode::not_ready)) return {listen(now), false};
  if (status.is(StatusCode::end_of_stream)) return {end_of_stream(), false};
  heard_ns_ = now;
  silent_ = false;

  // After a restart the source may begin again with what is already stored.
  if (state_.any && taken.sequence <= restored_sequence_ && (status.ok() || taken.sequence > 0)) return {{}, true};
  if (!status.ok()) return {status, true};
  if (newest_sequence_ != 0 && taken.sequence == newest_sequence_) {
    return {{StatusCode::frame_duplicated, taken.sequence}, true};
  }
  if (taken.sequence < newest_sequence_) {
    return {refuse(taken, {StatusCode::frame_out_of_order, taken.sequence, newest_sequence_}), true};
  }
  const Status stamp = check_stamp(taken, now);
  if (!stamp.ok()) return {refuse(taken, stamp), true};
  const TimeNs since_last = taken.time_ns - state_.last_time_ns;
  if (state_.any && static_cast<double>(since_last) < mission_.capture_interval_s * static_cast<double>(ns_per_s)) {
    return {refuse(taken, {}), true};
  }
  ILP_ASSERT_STEP(image_.width() > 0 && image_.height() > 0, taken.sequence);

  const std::int64_t steps = taken.sequence - state_.last_sequence;
  const std::int64_t missing = steps - 1 - left_out_;
  if (state_.any && steps > 0) interval_ns_ = since_last / steps;
  newest_sequence_ = taken.sequence;
  const Status kept = keep(taken);
  if (!kept.ok()) return {kept, true};
  left_out_ = 0;
  if (missing > 0) return {{StatusCode::frame_gap, taken.sequence, missing}, true};
  return {{}, true};
}

}  // namespace ilp
