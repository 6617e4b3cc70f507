// Keeps what the authentication of telecommands has to know through a restart, and tells who was refused.
#pragma once

#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/link/packet_router.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Lets authenticated telecommands go to the Telecommander only when the highest sequence number is on disk: whatever
/// happens, none is carried out twice. Where that cannot be written, commanding goes before it. Refused packets are an
/// event, with their number, at most every ten seconds. Does nothing where telecommands are not authenticated.
class TelecommandGuard final : public Component {
 public:
  static const CheckpointForm checkpoint;

  TelecommandGuard(Store& store, PacketRouter& router, Clock& clock);

  [[nodiscard]] const char* name() const override { return "telecommand_guard"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;
  [[nodiscard]] LastingMemory lasting() const override { return LastingMemory(cursor_, state_); }

 private:
  struct State {
    SequenceMarks marks;
  };
  Status keep_marks();
  Status news();

  Store& store_;
  PacketRouter& router_;
  Clock& clock_;
  Cursor cursor_;
  State state_;
  std::uint32_t told_refused_ = 0;
  TimeNs told_ns_ = 0;
  bool told_ = false;
  bool told_off_ = false;
};

}  // namespace ilp
