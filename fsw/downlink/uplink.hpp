// Files from the ground: receives them by CFDP, checks them and keeps them until they are activated
// (docs/file-delivery.md).
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/downlink/map_uplink.hpp"
#include "fsw/packets/cfdp_receiver.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// A part of FileDelivery. The bytes of open transfers are in memory: after a restart their senders are asked for a
/// retransmission. A file is in the store, as a record `uplink`, before the ground is informed.
///
/// There are few receivers, and anybody may send PDUs that nothing follows. Only the ground's entity therefore gets
/// one, and a transaction without progress gives way to a new one: after a second while its metadata or all octets of
/// its file are missing, else after twice `cfdp_timer_s`. A transaction number that comes again with another name, size
/// or checksum is another file: it gets no answer about the old one.
class Uplink {
 public:
  using Tables = StorePart<Writes<UplinkRecord>, Erases<UplinkRecord>>;

  /// Files of a map go to `map`; null: there is no folder for them.
  Uplink(Tables store, Clock& clock, const MissionParameters& mission, MapFolder* map);

  using Open = std::array<cfdp::OpenReception, limits::max_uplinks>;

  /// Requests retransmission of all open transfers.
  void restore(const Open& open, TimeNs now);
  /// The state that restore() needs after a restart. It must be on disk before anything is sent.
  [[nodiscard]] Open open() const;
  /// Receives a PDU; `false` when no receiver here takes it. `now` is time in contact, here and below.
  bool receive(const cfdp::Pdu& pdu, TimeNs now);
  void tick(TimeNs now);
  /// Stores a complete file in a transaction of its own, or one of a map in its folder; `event` gets the report.
  Status keep(TimeNs now, Status& event);

  /// The most urgent PDU; `false` when there is none. Its spans hold until the next call.
  [[nodiscard]] bool next(cfdp::Pdu& pdu);
  /// The PDU from next() was sent.
  void sent(TimeNs now);

 private:
  /// A closed transaction, kept to answer late PDUs.
  struct Closed {
    cfdp::Header header;
    bool used = false;
    cfdp::Condition condition = cfdp::Condition::no_error;
    cfdp::FileStatus file_status = cfdp::FileStatus::discarded;
    bool owes_ack = false;
    bool owes_finished = false;
    cfdp::Condition eof_condition = cfdp::Condition::no_error;
    cfdp::Carried carried;
  };

  bool receive_late(const cfdp::Pdu& pdu);
  /// A free receiver, or one that gives way; null when there is none.
  cfdp::Receiver* receiver_for(TimeNs now);
  void displace(cfdp::Receiver& receiver, TimeNs now);
  void remember(const cfdp::Receiver& receiver);
  Status check(const cfdp::Receiver& receiver, UplinkRecord& record);
  Status keep_parameters(cfdp::Receiver& receiver, TimeNs now, Status& event);
  void keep_part_of_map(cfdp::Receiver& receiver, TimeNs now, Status& event);
  Status store_file(const cfdp::Receiver& receiver, UplinkRecord& record);

  Tables store_;
  Clock& clock_;
  const MissionParameters& mission_;
  MapFolder* map_;
  MapUplinkWorkspace map_workspace_;
  std::array<cfdp::Receiver, limits::max_uplinks> receivers_{};
  std::array<Closed, limits::max_closed_transfers> closed_{};
  std::size_t next_closed_ = 0;
  Status abandoned_;
  TimeNs silent_until_ns_ = 0;  ///< about transactions that gave way
  std::size_t going_ = 0;       ///< index of what next() gave, in receivers_, then in closed_
  cfdp::PduKind going_kind_ = cfdp::PduKind::count;
};

/// Makes an uplinked file take effect, within a transaction of the caller. `not_found` for an unknown id,
/// `invalid_argument` for a file that was rejected; else all or nothing, as MissionText.
Status activate_uplink(StorePart<Changes<UplinkRecord>> store, std::int64_t id, TimeNs now, MissionParameters& mission);

}  // namespace ilp
