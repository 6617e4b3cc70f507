// What FileDelivery keeps, and what every part of its work has: the packets, the records of transfers.
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
/// A transfer rests for cfdp_rest_s, doubled with each fault or refusal so many times.
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
  std::int64_t sequence = 0;  ///< of the latest transaction
  Uplink::Open uplinks{};
};
/// A transfer in memory. Its record has the rest.
struct TransferSlot {
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
  std::int64_t adopted_through = 0;
  TimeNs last_ns = 0;
};
struct DeliveryWorkspace {
  DeliveryWorkspace(DeliveryTables store, Clock& clock, const MissionParameters& mission, MapFolder* map)
      : uplink(store, clock, mission, map) {}

  TimeNs contact_ns = 0;  ///< time in contact so far; all timers run by it
  std::uint32_t steps = 0;
  std::size_t save_from = 0;   ///< first transfer of the next single transactions, which rotate
  TimeNs silent_until_ns = 0;  ///< about PDUs that are rejected
  FixedVector<Status, 16> events;
  Uplink uplink;
  FixedVector<TransferSlot, limits::max_transfers> slots;
  FixedVector<LateAcknowledgement, max_late_acknowledgements> late;
  std::array<ClosedTransfer, limits::max_closed_transfers> closed{};
  std::size_t next_closed = 0;
  std::array<std::uint8_t, limits::max_pdu_bytes> pdu{};
  std::array<std::uint8_t, limits::max_pdu_bytes> data{};
};

class FileDeliveryPart {
 public:
  using Slot = TransferSlot;
  using State = DeliveryState;

  FileDeliveryPart(const DeliveryWiring& wiring, Cursor& cursor, State& state, DeliveryWork& work,
                   DeliveryWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), workspace_(workspace) {}

  /// Handles a fault of the store with one transfer: the transfer waits, or is abandoned.
  void quarantine(Slot& slot, const Status& fault, std::int64_t at = 0);
  void cancel(Slot& slot, const TransferRecord& record);
  void close(Slot& slot);
  [[nodiscard]] cfdp::SenderSettings settings() const;
  [[nodiscard]] cfdp::SendOrder order_of(const TransferRecord& record) const;
  static std::int64_t sequence_of(const Slot& slot);
  /// Keeps an event for the executive, which takes one with every step.
  void report(Status event);

 protected:
  const DeliveryWiring& wiring_;
  Cursor& cursor_;
  State& state_;
  DeliveryWork& work_;
  DeliveryWorkspace& workspace_;
};

}  // namespace ilp
