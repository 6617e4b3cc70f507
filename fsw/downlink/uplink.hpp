// Receives files from the ground by CFDP, checks them and keeps them until they are activated (docs/file-delivery.md).
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

/// A part of FileDelivery. The bytes of open transfers are only in memory: after a restart their senders are asked for
/// a retransmission. A complete file is in the store, as a record `uplink`, before the ground is informed.
///
/// There are few receivers, and anybody may send PDUs of transactions that never continue. Therefore only the ground's
/// entity gets a receiver, and a transaction without progress is replaced by a new one: after one second if its
/// metadata are missing or no data of its file have come, otherwise after twice `cfdp_timer_s`. A transaction number
/// that comes again with another name, size or checksum belongs to another file, and no answer about the earlier file
/// is sent.
class Uplink {
 public:
  using Tables = StorePart<Writes<UplinkRecord>, Erases<UplinkRecord>>;

  /// Files of a map go to `map`, which is null if there is no folder for them.
  Uplink(Tables store, Clock& clock, const MissionParameters& mission, MapFolder* map);

  using Open = std::array<cfdp::OpenReception, limits::max_uplinks>;

  /// Resumes the open transfers after a restart.
  void restore(const Open& open, TimeNs now);
  /// The state that restore() needs after a restart. It must be on disk before anything is sent.
  [[nodiscard]] Open open() const;
  /// Receives a PDU. Returns `false` if no receiver takes it. In all functions `now` is the time in contact.
  bool receive(const cfdp::Pdu& pdu, TimeNs now);
  /// Lets the timers of all transactions expire that are due.
  void tick(TimeNs now);
  /// Stores a complete file in its own transaction, or a file of a map in its folder. `event` gets the event to report.
  Status keep(TimeNs now, Status& event);

  /// Gives the most urgent PDU that is due. Returns `false` if none is due. Its spans are valid until the next call.
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
  /// A free receiver, or one whose transaction is displaced; null if there is none.
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
  TimeNs silent_until_ns_ = 0;  ///< until then displaced transactions are not reported
  std::size_t going_ = 0;       ///< index of the source of the PDU from next(): in receivers_, continued in closed_
  cfdp::PduKind going_kind_ = cfdp::PduKind::count;
};

/// Puts the parameters of an uplinked file into `mission`, in a transaction of the caller. Returns `not_found` for an
/// unknown id, `invalid_argument` for a file that was rejected, or the fault of MissionText; `mission` is then
/// unchanged.
Status activate_uplink(StorePart<Changes<UplinkRecord>> store, std::int64_t id, TimeNs now, MissionParameters& mission);

}  // namespace ilp
