// Takes telecommands from the link and from the schedule, carries them out, and reports what becomes of each.
#pragma once

#include "fsw/commanding/telecommand_service.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Services 1, 3, 5, 8, 11, 17 and 20 of ECSS-E-ST-70-41C (docs/commanding.md). Every telecommand whose primary header
/// can be read is answered. What a telecommand changes is committed before its success is reported: it acts on the
/// other components through records only, of which `command` carries most. Requests whose completion takes time, and
/// the schedule, survive a restart. While another process keeps the lock of the store, telecommands that change nothing
/// are carried out; any other one waits for two seconds from the beginning of the lock, and then fails with
/// `store_locked`.
///
/// It is the dispatcher; each service_N.cpp carries out the telecommands of one service, and open_requests.cpp follows
/// those whose completion takes time.
class Telecommander final : public StageComponent<ComponentId::telecommander> {
 public:
  static const CheckpointForm checkpoint;

  /// Parameters set by telecommand take effect in `mission`. The configuration makes them tentative; without it they
  /// are settings in the store.
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

  void receive();
  /// Whether the telecommand waits for the lock of the store, and all later ones with it.
  bool waits_for_lock(std::span<const std::uint8_t> packet);
  Status try_store();
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
  /// In memory only.
  void forget_entry(std::int64_t id);

  CommandingWiring wiring_;
  Cursor cursor_;
  State state_;
  CommandingWork work_;
  CommandingWorkspace workspace_;
};

}  // namespace ilp
