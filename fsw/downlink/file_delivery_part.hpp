// The data of FileDelivery, and the base class of its parts: PDUs, and the records of transfers.
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/uplink.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/cfdp_sender.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

using DeliveryTables = StageStore<ComponentId::file_delivery>;
/// A transfer rests for cfdp_rest_s. Each fault or refusal doubles this time, at most most_doublings times.
inline constexpr std::uint32_t most_doublings = 6;
inline constexpr std::size_t max_late_acknowledgements = 2 * limits::max_transfers;

struct DeliveryWiring {
  DeliveryTables store;
  PacketRouter& router;
  Clock& clock;
  const MissionParameters& mission;
  DeliveryCounts& counts;
  DeliveryBacklog& backlog;
  FlightMemory* memory;
};
struct DeliveryState {
  std::int64_t sequence = 0;  ///< number of the latest transaction
  Uplink::Open uplinks{};
};
/// A transfer in memory. Further data are in its record.
struct TransferSlot {
  std::int64_t id = 0;
  std::uint32_t bytes = 0;    ///< size of the file
  std::uint8_t priority = 0;  ///< 0 is the most urgent
  bool waiting = true;        ///< no transaction runs
  bool suspended = false;
  bool dirty = false;  ///< it differs from its record: none of its PDUs is sent before it is saved
  bool gone = false;   ///< it is over: the slot is freed after the commit
  std::uint32_t attempts = 0;
  std::uint32_t stalls = 0;
  std::uint32_t saved_progress = 0;  ///< progress, phase and time when it was saved last
  std::uint8_t saved_phase = 0;
  TimeNs saved_ns = 0;
  std::uint32_t faults = 0;  ///< faults of the store since its data could last be read
  bool lost = false;         ///< its record cannot be read and will be erased
  TimeNs not_before_ns = 0;  ///< earliest next attempt, after a refusal or a fault
  cfdp::Sender sender;
};
/// A transaction that is over, kept to answer late PDUs.
struct ClosedTransfer {
  std::uint64_t sequence = 0;
  std::uint64_t destination = 0;
  cfdp::Condition condition = cfdp::Condition::no_error;
};
struct LateAcknowledgement {
  cfdp::Header header;
  cfdp::Ack ack;
};
struct DeliveryWork {
  bool state_dirty = false;
  std::int64_t adopted_through = 0;  ///< transfers up to this one have a slot, or had one
  TimeNs last_ns = 0;
};
struct DeliveryWorkspace {
  DeliveryWorkspace(DeliveryTables store, Clock& clock, const MissionParameters& mission, MapFolder* map)
      : uplink(store, clock, mission, map) {}

  TimeNs contact_ns = 0;  ///< total time in contact in this boot, which all timers use
  std::uint32_t steps = 0;
  std::size_t save_from = 0;   ///< slot that was last saved in a transaction of its own; slots take turns
  TimeNs silent_until_ns = 0;  ///< until then rejected PDUs are not reported
  FixedVector<Status, 16> events;
  Uplink uplink;
  FixedVector<TransferSlot, limits::max_transfers> slots;
  FixedVector<LateAcknowledgement, max_late_acknowledgements> late;
  std::array<ClosedTransfer, limits::max_closed_transfers> closed{};
  std::size_t next_closed = 0;
  std::array<std::uint8_t, limits::max_pdu_bytes> pdu{};
  std::array<std::uint8_t, limits::max_pdu_bytes> data{};
};

/// Base class of the parts.
class FileDeliveryPart {
 public:
  using Slot = TransferSlot;
  using State = DeliveryState;

  FileDeliveryPart(const DeliveryWiring& wiring, Cursor& cursor, State& state, DeliveryWork& work,
                   DeliveryWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), workspace_(workspace) {}

  /// After a fault of the store with one transfer, at offset `at` of its file: the transfer waits, or is abandoned.
  void quarantine(Slot& slot, const Status& fault, std::int64_t at = 0);
  /// Cancels the transaction, or drops a waiting transfer.
  void cancel(Slot& slot, const TransferRecord& record);
  /// Marks the transfer as over.
  void close(Slot& slot);
  [[nodiscard]] cfdp::SenderSettings settings() const;
  [[nodiscard]] cfdp::SendOrder order_of(const TransferRecord& record) const;
  static std::int64_t sequence_of(const Slot& slot);
  /// Keeps an event, which a later step returns. Each step returns one.
  void report(Status event);

 protected:
  const DeliveryWiring& wiring_;
  Cursor& cursor_;
  State& state_;
  DeliveryWork& work_;
  DeliveryWorkspace& workspace_;
};

}  // namespace ilp
