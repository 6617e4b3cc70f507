// Delivers files to the ground and receives files from it by CFDP class 2 (docs/file-delivery.md).
#pragma once

#include "fsw/downlink/file_delivery_link.hpp"
#include "fsw/downlink/file_delivery_records.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Runs several transactions at once, the most urgent first. Every minor frame it receives PDUs, runs timers, saves
/// what has changed, then sends as much as the router takes. Everything reported to the ground is already on disk:
/// Finished is acknowledged only after the commit.
///
/// A transfer that fails delays no other: it waits for `cfdp_rest_s`, doubled each time up to 64 times, while the
/// others continue. After 10 faults, or 3 permanent ones, it is abandoned: the ground is informed that the rest will
/// not come, the record is erased, and Downlink makes the file again when its confirmation is overdue.
class FileDelivery final : public StageComponent<ComponentId::file_delivery> {
 public:
  static const CheckpointForm checkpoint;

  /// Takes transaction numbers from `memory`, where they outlive the database. Files of a map go to `map`.
  FileDelivery(Tables store, PacketRouter& router, Clock& clock, const MissionParameters& mission,
               DeliveryFigures& figures, FlightMemory* memory = nullptr, MapFolder* map = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

 private:
  using State = DeliveryState;
  using Slot = TransferSlot;

  void read_wishes();
  void wish(Slot& slot, const TransferRecord& record);
  void start_waiting();
  bool start(Slot& slot);
  void check(Slot& slot);
  void drop_gone();
  StepResult deliver();
  void count_backlog();
  Status next_event();
  FileDeliveryRecords records() { return {wiring_, cursor_, state_, work_, workspace_}; }
  FileDeliveryLink link() { return {wiring_, cursor_, state_, work_, workspace_}; }

  DeliveryWiring wiring_;
  Cursor cursor_;
  State state_;
  DeliveryWork work_;
  DeliveryWorkspace workspace_;
};

}  // namespace ilp
