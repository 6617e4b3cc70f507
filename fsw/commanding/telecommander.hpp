// Takes telecommands from the link and from the schedule, carries them out, and reports their verification.
#pragma once

#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Services 1, 3, 5, 8, 11, 17 and 20 of ECSS-E-ST-70-41C (docs/commanding.md). Every telecommand whose primary header
/// can be read is answered. Telecommands act on other components only through records, mostly `command`; these are
/// committed before success is reported. The schedule, and requests whose completion takes time, survive a restart.
/// While another process holds the store's lock, telecommands that change nothing are carried out. Any other
/// telecommand waits until two seconds after the begin of the lock, and then fails with `store_locked`.
///
/// This class dispatches telecommands. Each service_N.cpp carries out the telecommands of one service, and
/// open_requests.cpp follows requests whose completion takes time.
class Telecommander final : public StageComponent<ComponentId::telecommander> {
 public:
  static const CheckpointForm checkpoint;

  /// Parameters that are set by telecommand take effect in `mission`. `configuration` makes them tentative; if it is
  /// null, they are only stored as settings.
  Telecommander(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock, MissionParameters& mission,
                Configuration* configuration = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

  [[nodiscard]] const CommandingRecord& counts() const { return state_.counts; }

 private:
  using State = CommandingState;

  /// Takes telecommands from the link and carries them out.
  void receive();
  /// Whether the telecommand, and with it all later ones, must wait for the store's lock.
  bool waits_for_lock(std::span<const std::uint8_t> packet);
  Status try_store();
  /// Carries out the scheduled telecommands that are due.
  void release();
  void release_one(const ScheduleEntry& entry, TimeNs now);
  void carry_out(std::span<const std::uint8_t> packet, TimeNs nominal_ns, const ScheduleEntry* entry);
  Status perform(const ScheduleEntry* entry, ServiceCall& call);
  void apply_change(const TelecommandChange& change);
  void take_effect(bool accepted, const Status& status, bool from_the_link);
  Status follow_open_requests();
  Status write_counts();
  Status update_of_configuration();
  void drop_entry(std::int64_t id);
  /// Removes an entry of the schedule from memory only; drop_entry() also erases its record.
  void forget_entry(std::int64_t id);

  CommandingWiring wiring_;
  Cursor cursor_;
  State state_;
  CommandingWork work_;
  CommandingWorkspace workspace_;
};

}  // namespace ilp
