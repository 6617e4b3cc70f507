// Delivers files to the ground and receives files from it by CFDP class 2 (docs/file-delivery.md).
#pragma once

#include "fsw/downlink/file_delivery_link.hpp"
#include "fsw/downlink/file_delivery_records.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

/// Runs several transactions at the same time and sends the most urgent PDUs first. In every minor frame it receives
/// PDUs, runs timers, saves changes, and then sends as much as the router takes. Nothing is reported to the ground
/// before it is on disk: a Finished, for example, is acknowledged only after the commit.
///
/// A transfer that fails delays no other transfer. It waits for `cfdp_rest_s`; each further fault doubles this time, up
/// to a factor of 64. After 10 transient or 3 permanent faults it is abandoned: its transaction is cancelled, its
/// record is erased, and Downlink makes the file again when the confirmation is overdue.
class FileDelivery final : public StageComponent<ComponentId::file_delivery> {
 public:
  static const CheckpointForm checkpoint;

  /// Takes transaction numbers from `memory`, where they survive the loss of the database. Files of a map go to `map`.
  /// Both may be null.
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

  /// Reads the ground's requests from the records of all transfers.
  void read_wishes();
  /// Carries out the request in a transfer's record.
  void wish(Slot& slot, const TransferRecord& record);
  /// Starts waiting transfers, up to cfdp_open_transfers.
  void start_waiting();
  bool start(Slot& slot);
  void check(Slot& slot);
  /// Frees the slots of transfers that are over and saved.
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
