// Files from the ground: receives them by CFDP, checks them and keeps them until they are activated
// (docs/file-delivery.md).
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/link/cfdp_receiver.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// A part of FileDelivery. The bytes of transfers under way live in memory: after a restart their senders are asked
/// for them again. A file is in the store, as a record `uplink`, before the ground is told so.
///
/// There are few receivers, and anybody may send PDUs that nothing follows. So only the ground's entity gets one, and a
/// transaction that makes no progress gives way to a newcomer: after a second while its metadata or all octets of its
/// file are missing, else after twice `cfdp_timer_s`. A number that comes again with another name, size or checksum is
/// another file: no answer about the old one is given to it.
class Uplink {
 public:
  using Tables = StorePart<Writes<UplinkRecord>, Erases<UplinkRecord>>;

  Uplink(Tables store, Clock& clock, const MissionParameters& mission);

  using Open = std::array<cfdp::OpenReception, limits::max_uplinks>;

  /// Asks for everything of the transfers that were open.
  void restore(const Open& open, TimeNs now);
  /// What restore() needs after a restart; to be on disk before anything is sent.
  [[nodiscard]] Open open() const;
  /// A PDU for a receiver; `false` when it is for nobody here. `now` is time in contact, here and below.
  bool hear(const cfdp::Pdu& pdu, TimeNs now);
  void tick(TimeNs now);
  /// Stores a file that has become whole, in a transaction of its own; what is worth telling in `event`.
  Status keep(TimeNs now, Status& event);

  /// The PDU that wants to go first; `false` when none does. Its spans hold until the next call.
  [[nodiscard]] bool next(cfdp::Pdu& pdu);
  /// The one that next() gave has gone.
  void sent(TimeNs now);

 private:
  /// A transaction that is over, for what comes late.
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

  bool hear_late(const cfdp::Pdu& pdu);
  /// One that is free, or that has to give way; null where none has.
  cfdp::Receiver* receiver_for(TimeNs now);
  void displace(cfdp::Receiver& receiver, TimeNs now);
  void remember(const cfdp::Receiver& receiver);
  Status check(const cfdp::Receiver& receiver, UplinkRecord& record);
  Status store_file(const cfdp::Receiver& receiver, UplinkRecord& record);

  Tables store_;
  Clock& clock_;
  const MissionParameters& mission_;
  std::array<cfdp::Receiver, limits::max_uplinks> receivers_{};
  std::array<Closed, limits::max_closed_transfers> closed_{};
  std::size_t next_closed_ = 0;
  Status given_up_;
  TimeNs displaced_reported_ns_ = -1;
  std::size_t going_ = 0;  ///< place in receivers_, or behind them in closed_, of what next() gave
  cfdp::PduKind going_kind_ = cfdp::PduKind::count;
};

/// Within a transaction of the caller: makes an uplinked file take effect. `not_found` for an unknown id,
/// `invalid_argument` for a file that was rejected; else all or nothing, as MissionText.
Status activate_uplink(StorePart<Changes<UplinkRecord>> store, std::int64_t id, TimeNs now, MissionParameters& mission);

}  // namespace ilp
