// The receiver's side of one transaction of class 2 (CCSDS 727.0-B-5, 4.6.4, 4.6.6 to 4.6.8), for files of a bounded
// size: PDUs and time in, PDUs out. It knows neither store nor clock nor link.
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
  bool crc = false;                 ///< of the PDUs sent back
  TimeNs timer_ns = 10 * ns_per_s;  ///< a NAK or a Finished is sent again after it
  std::uint32_t timer_limit = 4;    ///< expiries without progress before the transaction ends
  TimeNs inactivity_ns = 300 * ns_per_s;
};

/// State that must survive a restart: once its EOF is acknowledged, a sender waits for requests.
struct OpenReception {
  bool used = false;
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

/// The file of a transaction, as far as it is known. The same number may come again with another file.
struct Carried {
  bool named = false;  ///< its metadata are known
  bool ended = false;  ///< its EOF is known
  std::uint32_t name_crc = 0;
  std::uint64_t stated_bytes = 0;
  std::uint32_t checksum = 0;
  std::uint64_t file_bytes = 0;

  void note(const Pdu& pdu);
  /// Metadata or an EOF that cannot belong to the same file.
  [[nodiscard]] bool contradicted_by(const Pdu& pdu) const;
};

enum class ReceivePhase : std::uint8_t {
  data,      ///< the file is not complete
  whole,     ///< the file is complete with the right checksum: the caller stores it and concludes
  finished,  ///< Finished is sent until it is acknowledged
  closed
};

struct OwedAnswers {
  bool eof_ack = false;
  bool nak = false;
  bool finished = false;
  bool keep_alive = false;
  std::uint32_t nak_from = 0;  ///< gaps that begin before it have been requested

  void request_all() {
    nak = true;
    nak_from = 0;
  }
};

/// All times are of a clock that stops out of contact. The object has about 70 KiB.
class Receiver {
 public:
  /// Starts the transaction of the first PDU, which receive() then takes.
  void begin(const Header& first, const ReceiverSettings& settings, TimeNs now);
  /// After a restart: requests retransmission of the whole file, or reports again how it ended.
  void resume(const OpenReception& open, const ReceiverSettings& settings, TimeNs now);
  /// Not `used` before the EOF is acknowledged, or when the transaction is over.
  [[nodiscard]] OpenReception open() const;
  /// Drops the transaction without informing the sender.
  void abandon();
  /// Receives a PDU of this transaction.
  void receive(const Pdu& pdu, TimeNs now);
  void tick(TimeNs now);
  /// The caller concludes on the complete file, or ends the transaction at any time.
  void conclude(Condition condition, FileStatus status, TimeNs now);

  /// The most urgent PDU; `false` when there is none.
  [[nodiscard]] bool next(PduKind& kind) const;
  /// Spans of the PDU point into this object.
  void build(PduKind kind, Pdu& pdu);
  void sent(PduKind kind, TimeNs now);

  [[nodiscard]] const Header& header() const { return header_; }
  [[nodiscard]] ReceivePhase phase() const { return phase_; }
  [[nodiscard]] Condition condition() const { return condition_; }
  [[nodiscard]] FileStatus file_status() const { return file_status_; }
  /// Terminated; longer names are cut.
  [[nodiscard]] const char* name() const { return name_; }
  [[nodiscard]] std::span<const std::uint8_t> file() const { return {file_.data(), file_bytes_}; }
  [[nodiscard]] const SegmentList& missing() const { return missing_; }
  /// The sender is known: its metadata were received, now or before a restart.
  [[nodiscard]] bool shown() const { return shown_; }
  /// Time of the latest new data, and the number of octets of the file received.
  [[nodiscard]] TimeNs progressed_ns() const { return progressed_ns_; }
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
  std::uint32_t nak_through_ = 0;  ///< end of the request in the NAK that was built
  std::uint32_t repeats_ = 0;
  TimeNs deadline_ns_ = 0;
  TimeNs received_ns_ = 0;
  TimeNs progressed_ns_ = 0;
  Carried carried_;
  SegmentList missing_;
  char name_[64] = {};
  std::array<std::uint8_t, 1024> options_{};  ///< gaps of a NAK, fault location of a Finished
  std::array<std::uint8_t, limits::max_uplink_bytes> file_{};
};

}  // namespace ilp::cfdp
