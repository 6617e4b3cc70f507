// The sender's side of one transaction of class 2 (CCSDS 727.0-B-5, 4.6.3, 4.6.4, 4.6.6 to 4.6.8): PDUs and time in,
// PDUs out. It knows neither store nor clock nor link.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/time.hpp"
#include "fsw/link/cfdp_gaps.hpp"
#include "fsw/link/cfdp_pdu.hpp"

namespace ilp::cfdp {

struct SenderSettings {
  std::uint32_t segment_bytes = 1000;  ///< of the file in one PDU
  std::uint32_t metadata_copies = 2;   ///< a receiver may drop file data that came before the metadata
  TimeNs timer_ns = 10 * ns_per_s;     ///< an EOF without an answer goes again
  std::uint32_t timer_limit = 4;       ///< times; then the transaction rests
  TimeNs rest_ns = 60 * ns_per_s;      ///< and goes on with metadata and EOF
  TimeNs prompt_ns = 0;                ///< time without news after the ACK of the EOF until a prompt; 0: none
};

/// What is sent, under which names.
struct SendOrder {
  Header header;
  char name[32] = {};
  std::uint32_t file_bytes = 0;
  std::uint8_t checksum_type = 0;
  std::uint32_t checksum = 0;
};

enum class SendPhase : std::uint8_t {
  data,        ///< metadata and file data go for the first time
  answer,      ///< everything has gone once; the EOF goes until it is answered, gaps are filled
  resting,     ///< there is no answer: nothing goes for a while
  cancelling,  ///< an EOF says that the rest will not come
  closed
};

enum class SendOutcome : std::uint8_t {
  open,
  delivered,  ///< Finished said: no error, complete, retained
  refused,    ///< Finished said anything else
  cancelled,  ///< by either side
  spent       ///< the receiver knows the number from an earlier file: this one has to go under another
};

/// One thing that wants to go; of a file's bytes where they stand.
struct SendItem {
  PduKind kind = PduKind::metadata;
  bool again = false;  ///< a retransmission
  Piece piece;
};

struct SenderCounts {
  std::uint32_t resent_bytes = 0;
  std::uint32_t bad_gaps = 0;      ///< beyond the file, or inverted
  std::uint32_t dropped_gaps = 0;  ///< that the list could not hold: the receiver asks again
  std::uint32_t gap_steps = 0;     ///< elementary steps of taking NAKs in
  std::uint32_t rests = 0;         ///< since the last answer
};

/// All times are of a clock that stands still out of contact.
///
/// A number may come again, and with it the answers to an earlier file: what a file carried does not stand in a
/// Finished. So "delivered" is believed only of a receiver that has shown that it works on this file: by a NAK, a
/// keep-alive, or an ACK of the EOF that says *active*. A Finished before that is not acknowledged, and the EOF goes
/// again, which such a receiver answers. One that calls the transaction over without having shown it is `spent`.
class Sender {
 public:
  /// From the first byte on.
  void begin(const SendOrder& order, const SenderSettings& settings);
  /// Behind a restart: the first `progress` bytes have gone before, `gaps` are asked for; with `all_sent` the EOF goes.
  void resume(const SendOrder& order, const SenderSettings& settings, std::uint32_t progress, bool all_sent,
              std::span<const Piece> gaps);

  /// A PDU of this transaction.
  void receive(const Pdu& pdu, TimeNs now);
  void tick(TimeNs now);
  /// What wants to go first; `false` when nothing does.
  [[nodiscard]] bool next(SendItem& item) const;
  /// The PDU of an item; the bytes of file data are for the caller to add. Spans point into this object.
  void build(const SendItem& item, Pdu& pdu) const;
  /// It has gone.
  void sent(const SendItem& item, TimeNs now);

  /// Nothing goes, no timer runs; what comes is still heard.
  void suspend() { suspended_ = true; }
  void unsuspend(TimeNs now);
  /// `checksum`: of the first progress() bytes.
  void cancel(std::uint32_t checksum, TimeNs now);
  /// A keep-alive is asked for.
  void prompt() { owes_prompt_ = true; }

  [[nodiscard]] const SendOrder& order() const { return order_; }
  [[nodiscard]] SendPhase phase() const { return phase_; }
  [[nodiscard]] SendOutcome outcome() const { return outcome_; }
  [[nodiscard]] Condition condition() const { return condition_; }
  [[nodiscard]] bool suspended() const { return suspended_; }
  /// All bytes before it have gone once.
  [[nodiscard]] std::uint32_t progress() const { return progress_; }
  [[nodiscard]] const PieceList& gaps() const { return gaps_; }
  [[nodiscard]] const SenderCounts& counts() const { return counts_; }
  /// What the receiver's latest keep-alive said.
  [[nodiscard]] std::uint64_t received_bytes() const { return received_bytes_; }

 private:
  void hear_nak(const Pdu& pdu, TimeNs now);
  void hear_ack(const Ack& ack, TimeNs now);
  void hear_finished(const Finished& finished);
  void deliver();
  void expire(TimeNs now);
  [[nodiscard]] Piece segment_of(Piece piece) const;

  SendOrder order_;
  SenderSettings settings_;
  SendPhase phase_ = SendPhase::closed;
  SendOutcome outcome_ = SendOutcome::open;
  Condition condition_ = Condition::no_error;
  bool suspended_ = false;
  bool owes_finished_ack_ = false;
  bool owes_eof_ = false;
  bool owes_prompt_ = false;
  bool eof_acknowledged_ = false;
  bool shown_ = false;              ///< the receiver works on this file
  bool held_finished_ = false;      ///< it has said delivered before it has shown that
  std::uint32_t over_answers_ = 0;  ///< times that the receiver has called the transaction over
  std::uint32_t owed_metadata_ = 0;
  std::uint32_t repeats_ = 0;
  std::uint32_t progress_ = 0;
  std::uint32_t cancel_checksum_ = 0;
  TimeNs deadline_ns_ = 0;
  TimeNs heard_ns_ = 0;
  std::uint64_t received_bytes_ = 0;
  PieceList gaps_;
  SenderCounts counts_;
  std::uint8_t fault_location_[10] = {};
  std::uint8_t fault_location_bytes_ = 0;
};

}  // namespace ilp::cfdp
