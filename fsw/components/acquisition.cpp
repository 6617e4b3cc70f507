#include "fsw/components/acquisition.hpp"

#include <cstring>

namespace ilp {
namespace {
constexpr std::uint32_t layout = 1;
}

Acquisition::Acquisition(Store& store, Camera& camera, Clock& clock, const MissionParameters& mission)
    : store_(store), camera_(camera), clock_(clock), mission_(mission) {}

Status Acquisition::restore() {
  cursor_ = {};
  state_ = {};
  const Status status = load_checkpoint(store_, ComponentId::acquisition, cursor_, layout, state_);
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

StepResult Acquisition::step(TimeNs deadline) {
  static_cast<void>(deadline);
  if (state_.ended) return {};
  CameraFrame taken;
  const Status status = camera_.capture(clock_.now(), image_, taken);
  if (status.is(StatusCode::not_ready)) return {};
  if (status.is(StatusCode::end_of_stream)) return {end_of_stream(), false};
  if (!status.ok()) return {status, true};

  // After a restart the source may begin again with what is already stored.
  if (state_.any && taken.sequence <= state_.last_sequence) return {{}, true};
  const TimeNs since_last = taken.time_ns - state_.last_time_ns;
  if (state_.any && since_last <= 0) return {{StatusCode::time_not_monotonic, taken.sequence, -since_last}, true};
  if (state_.any && static_cast<double>(since_last) < mission_.capture_interval_s * static_cast<double>(ns_per_s)) {
    return {{}, true};
  }
  const std::int64_t missing = taken.sequence - state_.last_sequence - 1;
  ILP_ASSERT_STEP(image_.width() > 0 && image_.height() > 0, taken.sequence);
  const Status kept = keep(taken);
  if (!kept.ok()) return {kept, true};
  if (missing > 0 && mission_.capture_interval_s <= 0) return {{StatusCode::frame_gap, taken.sequence, missing}, true};
  return {{}, true};
}

}  // namespace ilp
