// Keeps the state of telecommand authentication over restarts, and reports refused packets.
#pragma once

#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Releases authenticated telecommands to the Telecommander only when their highest sequence number is stored in the
/// nonvolatile memory or in the database, so that no telecommand is executed twice, even after a restart. If neither
/// can be written, telecommands wait for ten seconds and are then released without stored sequence numbers, with the
/// event marks_not_kept. The number of refused packets is reported as an event, at most every ten seconds. Without
/// authentication of telecommands the component does nothing.
class TelecommandGuard final : public StageComponent<ComponentId::telecommand_guard> {
 public:
  static const CheckpointForm checkpoint;

  /// Sequence numbers that are stored in `memory` survive the loss of the database. `memory` may be null.
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
    std::int64_t unkept = 0;  ///< telecommands that were released without stored marks since the last report
    std::uint32_t reported_refused = 0;
    bool reported = false;
    bool reported_off = false;
    bool failing = false;  ///< marks could not be stored since `failing_ns`
  };
  /// Stores the marks if they have changed.
  Status keep_marks();
  Status keep_in_memory(const SequenceMarks& marks);
  Status keep_in_store(State& after);
  /// Releases telecommands although their marks cannot be stored, once they have waited long enough.
  Status go_before(const Status& fault);
  Status updates();

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Workspace workspace_;
};

}  // namespace ilp
