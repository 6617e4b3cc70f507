// The receiver's side of one transaction of class 2 (CCSDS 727.0-B-5, 4.6.4, 4.6.6 to 4.6.8), for files of at most
// limits::max_uplink_bytes. The caller passes received PDUs and the time, and sends the PDUs that are due.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/time.hpp"
#include "fsw/packets/cfdp_checksum.hpp"
#include "fsw/packets/cfdp_gaps.hpp"
#include "fsw/packets/cfdp_pdu.hpp"

namespace ilp::cfdp {

struct ReceiverSettings {
  bool crc = false;                       ///< PDUs to the sender have a CRC
  TimeNs timer_ns = 10 * ns_per_s;        ///< time after which a NAK or a Finished is sent again
  std::uint32_t timer_limit = 4;          ///< expiries of the timer without progress before the transaction ends
  TimeNs inactivity_ns = 300 * ns_per_s;  ///< time without any PDU after which the transaction ends
};

/// State that must survive a restart: a sender whose EOF was acknowledged sends no more without a request.
struct OpenReception {
  bool used = false;  ///< false: there is no reception
  bool large_file = false;
  std::uint8_t id_length = 0;
  std::uint8_t sequence_length = 0;
  bool concluded = false;  ///< Finished must be sent
  Condition condition = Condition::no_error;
  FileStatus file_status = FileStatus::discarded;
  std::uint32_t checksum = 0;
  std::uint32_t file_bytes = 0;
  std::uint64_t source = 0;
  std::uint64_t sequence = 0;
  std::uint64_t destination = 0;
  bool operator==(const OpenReception&) const = default;
};

/// What is known of the file of a transaction. A sender may use the same transaction number again for another file.
struct Carried {
  bool named = false;              ///< its metadata are known
  bool ended = false;              ///< its EOF is known
  std::uint32_t name_crc = 0;      ///< CRC-32 of the destination name
  std::uint64_t stated_bytes = 0;  ///< size of the file from the metadata
  std::uint32_t checksum = 0;      ///< from the EOF
  std::uint64_t file_bytes = 0;    ///< size of the file from the EOF

  /// Notes the contents of the first metadata and of the first EOF.
  void note(const Pdu& pdu);
  /// `pdu` is metadata or an EOF of another file.
  [[nodiscard]] bool contradicted_by(const Pdu& pdu) const;
};

enum class ReceivePhase : std::uint8_t {
  data,      ///< the file is not complete
  whole,     ///< the file is complete with the right checksum: the caller stores it and calls conclude()
  finished,  ///< Finished is sent until it is acknowledged
  closed
};

/// PDUs that are due.
struct OwedAnswers {
  bool eof_ack = false;
  bool nak = false;
  bool finished = false;
  bool keep_alive = false;
  std::uint32_t nak_from = 0;  ///< gaps that begin before this offset have been requested

  void request_all() {
    nak = true;
    nak_from = 0;
  }
};

/// All times are those of a clock that stops out of contact. The size of the object is about 70 KiB.
class Receiver {
 public:
  /// Starts the transaction of its first PDU, whose header is `first`. The caller then passes that PDU to receive().
  void begin(const Header& first, const ReceiverSettings& settings, TimeNs now);
  /// After a restart: requests the complete file again, or sends Finished again if the transaction was concluded.
  void resume(const OpenReception& open, const ReceiverSettings& settings, TimeNs now);
  /// The state for resume(). `used` is false before an EOF or a conclusion, and when the transaction is closed.
  [[nodiscard]] OpenReception open() const;
  /// Drops the transaction without informing the sender.
  void abandon();
  /// Receives a PDU of this transaction.
  void receive(const Pdu& pdu, TimeNs now);
  /// Lets the timers expire that are due.
  void tick(TimeNs now);
  /// Ends the transaction: from now on Finished is sent with `condition` and `status`. The caller calls it once it has
  /// stored the complete file, and may call it earlier to end the transaction.
  void conclude(Condition condition, FileStatus status, TimeNs now);

  /// Gives the kind of the most urgent PDU that is due. Returns `false` when none is due.
  [[nodiscard]] bool next(PduKind& kind) const;
  /// Builds the PDU of this kind. Its spans point into this object.
  void build(PduKind kind, Pdu& pdu);
  /// The caller has sent the PDU that was built last.
  void sent(PduKind kind, TimeNs now);

  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] ReceivePhase phase() const { return phase_; }
  [[nodiscard]] Condition condition() const { return condition_; }
  [[nodiscard]] FileStatus file_status() const { return file_status_; }
  /// Destination name from the metadata, terminated. At most 63 octets are kept.
  [[nodiscard]] const char* name() const { return name_; }
  /// The content of the file; empty before the EOF.
  [[nodiscard]] std::span<const std::uint8_t> file() const { return {file_.data(), file_bytes_}; }
  /// Gaps between the received data, and after the EOF up to the end of the file.
  [[nodiscard]] const SegmentList& missing() const { return missing_; }
  /// The sender's metadata were received in this boot, or the transaction was resumed.
  [[nodiscard]] bool shown() const { return shown_; }
  /// Time at which data, metadata or EOF that were new came last.
  [[nodiscard]] TimeNs progressed_ns() const { return progressed_ns_; }
  /// Number of octets of the file that were received.
  [[nodiscard]] std::uint32_t octets() const { return end_ - octets_in(missing_); }
  [[nodiscard]] const Carried& carried() const { return carried_; }

 private:
  void receive_metadata(const Metadata& metadata, TimeNs now);
  void receive_data(const FileData& data, TimeNs now);
  void receive_eof(const EndOfFile& eof, TimeNs now);
  void complete_if_whole(TimeNs now);

  Header header_;
  ReceiverSettings settings_;
  ReceivePhase phase_ = ReceivePhase::closed;
  Condition condition_ = Condition::no_error;
  FileStatus file_status_ = FileStatus::discarded;
  bool metadata_ = false;
  bool shown_ = false;
  bool eof_ = false;
  OwedAnswers owed_;
  Condition eof_condition_ = Condition::no_error;
  std::uint8_t checksum_type_ = 0;
  std::uint32_t checksum_ = 0;
  std::uint32_t file_bytes_ = 0;   ///< known after the EOF
  std::uint32_t end_ = 0;          ///< end of the received data
  std::uint32_t nak_through_ = 0;  ///< end of the range that the latest NAK covers
  std::uint32_t repeats_ = 0;      ///< expiries of the timer since the latest progress
  TimeNs deadline_ns_ = 0;         ///< when the timer expires
  TimeNs received_ns_ = 0;         ///< time of the latest PDU
  TimeNs progressed_ns_ = 0;
  Carried carried_;
  SegmentList missing_;
  char name_[64] = {};
  std::array<std::uint8_t, 1024> options_{};  ///< encoded gaps of a NAK, or fault location of a Finished
  std::array<std::uint8_t, limits::max_uplink_bytes> file_{};
};

}  // namespace ilp::cfdp
