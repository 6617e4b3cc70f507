// The sender's side of one transaction of class 2 (CCSDS 727.0-B-5, 4.6.3, 4.6.4, 4.6.6 to 4.6.8). The caller passes
// received PDUs and the time, and sends the PDUs that are due.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/time.hpp"
#include "fsw/packets/cfdp_gaps.hpp"
#include "fsw/packets/cfdp_pdu.hpp"

namespace ilp::cfdp {

struct SenderSettings {
  std::uint32_t segment_bytes = 1000;  ///< most octets of the file in one PDU
  std::uint32_t metadata_copies = 2;   ///< number sent at the beginning; a receiver may drop data before the metadata
  TimeNs timer_ns = 10 * ns_per_s;     ///< time after which an EOF without an answer is sent again
  std::uint32_t timer_limit = 4;       ///< retransmissions of the EOF before the transaction rests
  TimeNs rest_ns = 60 * ns_per_s;      ///< duration of the rest; then metadata and EOF are sent again
  TimeNs prompt_ns = 0;                ///< time without any PDU after the ACK of the EOF until a prompt; 0: no prompts
};

/// The file to send and its names.
struct SendOrder {
  Header header;
  char name[32] = {};  ///< name at the sender and at the receiver
  std::uint32_t file_bytes = 0;
  std::uint8_t checksum_type = 0;
  std::uint32_t checksum = 0;
};

enum class SendPhase : std::uint8_t {
  data,        ///< first transmission of metadata and file data
  answer,      ///< everything was sent once; the EOF is sent until it is answered, gaps are filled
  resting,     ///< the receiver does not answer: nothing is sent for a while
  cancelling,  ///< an EOF reports that the remaining data will not be sent
  closed
};

enum class SendOutcome : std::uint8_t {
  open,
  delivered,  ///< Finished reported: no error, complete, retained
  refused,    ///< Finished reported anything else
  cancelled,  ///< cancelled by either side
  spent       ///< the receiver knows the number from an earlier file: this file needs another number
};

/// One PDU to send.
struct SendItem {
  PduKind kind = PduKind::metadata;
  bool again = false;  ///< retransmission of file data
  Segment segment;     ///< range of the file in a PDU of file data
};

struct SenderCounts {
  std::uint32_t resent_bytes = 0;
  std::uint32_t bad_gaps = 0;      ///< requested gaps that end beyond the file or are empty or inverted
  std::uint32_t dropped_gaps = 0;  ///< gaps that the list could not hold: the receiver requests them again
  std::uint32_t gap_steps = 0;     ///< elementary steps spent on NAKs
  std::uint32_t rests = 0;         ///< rests since the last PDU of the receiver
};

/// All times are those of a clock that stops out of contact.
///
/// A transaction number may be used again, and answers to an earlier file may still arrive: a Finished does not say
/// which file it is about. A Finished that reports the file as retained is therefore accepted only after the receiver
/// has shown that it works on this file: by a NAK, a keep-alive, or an ACK of the EOF with status *active*. An earlier
/// one is not acknowledged, and the EOF is sent again, so that the receiver shows its state in the ACK. If the receiver
/// reports the transaction as terminated without having worked on this file, the number is `spent`.
class Sender {
 public:
  /// Starts the transmission of the file from its first byte.
  void begin(const SendOrder& order, const SenderSettings& settings);
  /// After a restart: continues after the first `progress` bytes and retransmits `gaps`. With `all_sent` all data were
  /// sent, and the EOF follows the gaps.
  void resume(const SendOrder& order, const SenderSettings& settings, std::uint32_t progress, bool all_sent,
              std::span<const Segment> gaps);

  /// Receives a PDU of this transaction.
  void receive(const Pdu& pdu, TimeNs now);
  /// Lets the timers expire that are due.
  void tick(TimeNs now);
  /// Gives the most urgent PDU that is due. Returns `false` when none is due.
  [[nodiscard]] bool next(SendItem& item) const;
  /// Builds the PDU of an item. The caller adds the bytes of file data. The PDU's spans point into this object.
  void build(const SendItem& item, Pdu& pdu) const;
  /// The caller has sent the item.
  void sent(const SendItem& item, TimeNs now);

  /// Sends nothing but the ACK of a Finished, and stops all timers. PDUs are still received.
  void suspend() { suspended_ = true; }
  void unsuspend(TimeNs now);
  /// Cancels the transaction by an EOF. `checksum` is that of the first progress() bytes.
  void cancel(std::uint32_t checksum, TimeNs now);
  /// Sends a prompt, by which the receiver sends a NAK at once.
  void prompt() { owes_prompt_ = true; }

  [[nodiscard]] const SendOrder& order() const { return order_; }
  [[nodiscard]] SendPhase phase() const { return phase_; }
  [[nodiscard]] SendOutcome outcome() const { return outcome_; }
  [[nodiscard]] Condition condition() const { return condition_; }
  /// End of the data that were sent at least once.
  [[nodiscard]] std::uint32_t progress() const { return progress_; }
  /// Requested data that were not sent again yet.
  [[nodiscard]] const SegmentList& gaps() const { return gaps_; }
  [[nodiscard]] const SenderCounts& counts() const { return counts_; }

 private:
  void receive_nak(const Pdu& pdu, TimeNs now);
  void receive_ack(const Ack& ack, TimeNs now);
  void receive_finished(const Finished& finished);
  void deliver();
  void expire(TimeNs now);
  [[nodiscard]] Segment segment_of(Segment segment) const;

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
  bool held_finished_ = false;      ///< the receiver reported the file as retained before `shown_` was true
  std::uint32_t over_answers_ = 0;  ///< reports that the transaction is over
  std::uint32_t owed_metadata_ = 0;
  std::uint32_t repeats_ = 0;  ///< EOFs and prompts since the last PDU of the receiver
  std::uint32_t progress_ = 0;
  std::uint32_t cancel_checksum_ = 0;
  TimeNs deadline_ns_ = 0;
  TimeNs received_ns_ = 0;
  SegmentList gaps_;
  SenderCounts counts_;
  std::uint8_t fault_location_[10] = {};
  std::uint8_t fault_location_bytes_ = 0;
};

}  // namespace ilp::cfdp
