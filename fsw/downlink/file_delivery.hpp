// Delivers files to the ground and receives files from it by CFDP class 2 (docs/file-delivery.md).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/uplink.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/cfdp_sender.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"

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

  /// Takes transaction numbers from `memory`, where they outlive the database.
  FileDelivery(Tables store, PacketRouter& router, Clock& clock, const MissionParameters& mission,
               DeliveryFigures& figures, FlightMemory* memory = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

 private:
  static constexpr std::size_t max_late_acknowledgements = 2 * limits::max_transfers;

  struct Wiring {
    Tables store;
    PacketRouter& router;
    Clock& clock;
    const MissionParameters& mission;
    DeliveryCounts& counts;
    DeliveryBacklog& backlog;
    FlightMemory* memory;
  };
  struct State {
    std::int64_t sequence = 0;  ///< of the latest transaction
    Uplink::Open uplinks{};
  };
  /// A transfer in memory. Its record has the rest.
  struct Slot {
    std::int64_t id = 0;
    std::uint32_t bytes = 0;  ///< of the file
    std::uint8_t priority = 0;
    bool waiting = true;  ///< no transaction runs
    bool suspended = false;
    bool dirty = false;  ///< differs from its record: nothing of it is sent
    bool gone = false;   ///< over: the slot is freed after the commit
    std::uint32_t attempts = 0;
    std::uint32_t stalls = 0;
    std::uint32_t saved_progress = 0;
    std::uint8_t saved_phase = 0;
    TimeNs saved_ns = 0;
    std::uint32_t faults = 0;  ///< faults of the store since it last answered for this transfer
    bool lost = false;         ///< its record cannot be read and is erased
    TimeNs not_before_ns = 0;  ///< earliest next attempt, after a refusal or a fault
    cfdp::Sender sender;
  };
  struct Closed {
    std::uint64_t sequence = 0;
    std::uint64_t destination = 0;
    cfdp::Condition condition = cfdp::Condition::no_error;
  };
  struct LateAcknowledgement {
    cfdp::Header header;
    cfdp::Ack ack;
  };
  struct Work {
    bool state_dirty = false;
    std::int64_t adopted_through = 0;
    TimeNs last_ns = 0;
  };
  struct Workspace {
    Workspace(Tables store, Clock& clock, const MissionParameters& mission) : uplink(store, clock, mission) {}

    TimeNs contact_ns = 0;  ///< time in contact so far; all timers run by it
    std::uint32_t steps = 0;
    std::size_t save_from = 0;  ///< first transfer of the next single transactions, which rotate
    TimeNs rejection_reported_ns = -1;
    FixedVector<Status, 16> events;
    Uplink uplink;
    FixedVector<Slot, limits::max_transfers> slots;
    FixedVector<LateAcknowledgement, max_late_acknowledgements> late;
    std::array<Closed, limits::max_closed_transfers> closed{};
    std::size_t next_closed = 0;
    std::array<std::uint8_t, limits::max_pdu_bytes> pdu{};
    std::array<std::uint8_t, limits::max_pdu_bytes> data{};
  };

  // Input
  void take_in();
  void hear(std::span<const std::uint8_t> bytes);
  void hear_as_sender(const cfdp::Pdu& pdu);
  void answer_late(const cfdp::Pdu& finished, cfdp::TransactionStatus status);
  // Slots and their records
  Status adopt_new();
  Status adopt(const TransferRecord& record);
  /// A transfer that is no longer in the store is marked as gone.
  Status find(Slot& slot, TransferRecord& record, bool& there);
  void read_wishes();
  void wish(Slot& slot, const TransferRecord& record);
  void cancel(Slot& slot, const TransferRecord& record);
  /// Handles a fault of the store with one transfer: the transfer waits, or is abandoned.
  void set_aside(Slot& slot, const Status& fault, std::int64_t at = 0);
  Status drop_damaged(std::int64_t id);
  void start_waiting();
  bool start(Slot& slot);
  void look_at(Slot& slot);
  void mark_changes(Slot& slot);
  /// Saves in one transaction. If that fails, saves some of the transfers in one transaction each.
  Status save();
  Status save_checkpoint_and(std::span<Slot> slots);
  Status save(Slot& slot);
  void close(Slot& slot);
  void drop_gone();
  StepResult deliver();
  void count_backlog();
  // Output
  void send();
  bool send_late();
  bool send_uplink_answers();
  Status send_item(Slot& slot, const cfdp::SendItem& item);
  Slot* most_urgent(cfdp::SendItem& item);

  [[nodiscard]] cfdp::SenderSettings settings() const;
  [[nodiscard]] cfdp::SendOrder order_of(const TransferRecord& record) const;
  static std::int64_t sequence_of(const Slot& slot);
  /// Keeps an event for the executive, which takes one with every step.
  void report(Status event);
  Status next_event();

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
