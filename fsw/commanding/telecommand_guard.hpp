// Keeps the state of telecommand authentication over restarts, and reports refused packets.
#pragma once

#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Releases authenticated telecommands to the Telecommander only when the highest sequence number is stored, in the
/// nonvolatile memory beside the database or in the database itself: no telecommand is ever executed twice. If neither
/// can be written, telecommands wait for ten seconds. After that, commanding takes precedence, with the event
/// marks_not_kept, until one of the two can be written again. Refused packets are reported as an event with their
/// number, at most every ten seconds. Without authentication of telecommands it does nothing.
class TelecommandGuard final : public StageComponent<ComponentId::telecommand_guard> {
 public:
  static const CheckpointForm checkpoint;

  /// In `memory` the marks outlive the database.
  TelecommandGuard(Tables store, PacketRouter& router, Clock& clock, FlightMemory* memory = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, NoMembers{}, workspace_);
  }

 private:
  struct Wiring {
    Tables store;
    PacketRouter& router;
    Clock& clock;
    FlightMemory* memory;
  };
  struct alignas(8) State {
    SequenceMarks marks;
  };
  struct Workspace {
    TimeNs reported_ns = 0;
    TimeNs failing_ns = 0;
    TimeNs reported_failing_ns = 0;
    std::int64_t unkept = 0;  ///< telecommands released without marks since the last report of it
    std::uint32_t reported_refused = 0;
    bool reported = false;
    bool reported_off = false;
    bool failing = false;  ///< marks have not been kept since
  };
  Status keep_marks();
  Status keep_in_memory(const SequenceMarks& marks);
  Status keep_in_store(State& after);
  /// Releases telecommands though their marks cannot be kept.
  Status go_before(const Status& fault);
  Status updates();

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Workspace workspace_;
};

}  // namespace ilp
