// Receives files on the ground by CFDP class 2 (CCSDS 727.0-B-5, 4.6.4). Written from the standard, independently of
// the flight software. PDUs may be forged, so that memory and time are bounded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fsw/packets/cfdp_pdu.hpp"

namespace ilp::ground_cfdp {

// The received octets of a file, in any order, and the gaps between them. Memory and time depend on the amount of
// received data, not on its offset in the file.

class ReceivedSegments {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Adds octets at `offset`. Octets that are held already are not replaced. `offset` + size must be at most 2^63.
  /// Returns the number of new octets.
  std::uint64_t add(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// Whether all octets [0, end) are held.
  [[nodiscard]] bool whole(std::uint64_t end) const;
  /// The gaps in [begin, end), ascending, at most `most` of them.
  [[nodiscard]] std::vector<cfdp::Gap> gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const;
  /// The octets [0, end). whole(end) must be true.
  [[nodiscard]] Bytes file(std::uint64_t end) const;

  /// Memory in bytes, including the bookkeeping of each segment.
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  std::map<std::uint64_t, Bytes> segments_;      ///< key: offset; segments do not overlap
  std::map<std::uint64_t, std::uint64_t> runs_;  ///< ranges without gaps; key: begin; value: end
  std::uint64_t held_bytes_ = 0;
};

struct CfdpReceiverSettings {
  std::uint64_t entity = 2;
  double timer_s = 5;                       ///< time after which a NAK or a Finished is repeated
  int limit = 1000;                         ///< repetitions without an answer after which the transaction ends
  bool immediate_nak = true;                ///< true: request a gap when it is detected; false: only after the EOF
  bool forget_data_before_metadata = true;  ///< discard file data before the metadata, as some receivers do
  std::size_t gaps_in_a_nak = 100;          ///< largest number of gaps in one NAK PDU
  std::size_t gaps_at_once = 1000;          ///< largest number of gaps requested at a time, in one or more NAK PDUs
  std::uint64_t max_file_bytes = std::uint64_t{256} << 20U;
  /// Limits of the number of open transactions and of their data. If a limit would be exceeded, the transaction that
  /// has been silent for longest is dropped. If its sender sends again, the whole file is requested.
  std::size_t max_open = 256;
  std::uint64_t max_held_bytes = std::uint64_t{512} << 20U;
  /// Number of ended transactions whose answers are kept for senders that repeat an EOF; the oldest is dropped first.
  std::size_t max_closed = 1024;
};

struct CfdpReceiverCounts {
  std::uint64_t pdus = 0, malformed = 0, not_for_us = 0;
  std::uint64_t files = 0, checksum_failures = 0, abandoned = 0;
  std::uint64_t data_bytes = 0;      ///< octets of file data, including repeated ones
  std::uint64_t repeated_bytes = 0;  ///< octets that were held already
  std::uint64_t forgotten = 0;       ///< transactions dropped because of a limit
  std::uint64_t restarted = 0;       ///< transactions whose number was used again for another file
  std::uint64_t out_of_range = 0;    ///< PDUs with data beyond the end of the file or the largest file size
};

/// Times are in seconds of any monotonic clock.
///
/// Source entity and sequence number identify a transaction. The answer of an ended transaction is kept, and sent again
/// after a repeated EOF. If a number comes again with other metadata, or with an EOF of another size or checksum, a new
/// file begins, and the data of the old one are discarded.
class CfdpReceiver {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Send = std::function<void(const Bytes& pdu)>;
  /// Called with a complete file whose checksum is right; returns false if the file cannot be stored.
  using Keep = std::function<bool(const std::string& name, const Bytes& file)>;

  CfdpReceiver(CfdpReceiverSettings settings, Send send, Keep keep);

  /// Takes a PDU.
  void receive(std::span<const std::uint8_t> bytes, double now);
  /// Sends NAK and Finished PDUs whose time has come; to be called regularly.
  void tick(double now);
  /// Ends all open transactions.
  void cancel_all(double now);

  [[nodiscard]] const CfdpReceiverCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t open() const { return transactions_.size(); }
  [[nodiscard]] std::size_t closed() const { return closed_.size(); }
  /// Memory of the files that are being received, bytes.
  [[nodiscard]] std::uint64_t held_bytes() const { return held_bytes_; }

 private:
  struct FileMetadata {
    std::string name;
    std::uint8_t checksum_type = 0;
    std::uint64_t file_bytes = 0;
    friend bool operator==(const FileMetadata&, const FileMetadata&) = default;
  };
  struct FileEnd {
    std::uint32_t checksum = 0;
    std::uint64_t file_bytes = 0;
    friend bool operator==(const FileEnd&, const FileEnd&) = default;
  };
  struct Transaction {
    cfdp::Header header;
    std::optional<FileMetadata> metadata;
    std::optional<FileEnd> eof;
    std::uint64_t end = 0;  ///< largest end offset of received data
    ReceivedSegments segments;
    bool finished = false;  ///< Finished has been sent, and its ACK is expected
    cfdp::Finished answer;
    double received_s = 0, next_s = 0;
    int repeats = 0;
  };
  struct Closed {
    std::optional<FileMetadata> metadata;
    std::optional<FileEnd> eof;
    cfdp::Finished answer;
  };
  using Key = std::pair<std::uint64_t, std::uint64_t>;

  static FileMetadata metadata_of(const cfdp::Metadata& metadata);
  Transaction& begin(const Key& key, double now);
  void make_room(const Key& but, std::size_t most_open, std::uint64_t more_bytes);
  void close(const Key& key);
  void drop_data(Transaction& t);
  void restart(Transaction& t);
  [[nodiscard]] bool is_over(const Key& key, const cfdp::Pdu& pdu);
  void receive_metadata(Transaction& t, const cfdp::Metadata& metadata, double now);
  void receive_data(const Key& key, Transaction& t, const cfdp::FileData& data, double now);
  void receive_eof(Transaction& t, const cfdp::EndOfFile& eof, double now);
  void receive_about(const Key& key, const cfdp::Pdu& pdu);
  void finish(Transaction& t, cfdp::Condition condition, cfdp::FileStatus status, double now);
  void complete_if_whole(Transaction& t, double now);
  void send_naks(const Transaction& t, std::uint64_t from);
  void send_finished(const cfdp::Header& header, const cfdp::Finished& answer);
  void acknowledge_eof(const cfdp::Header& header, const cfdp::EndOfFile& eof, cfdp::TransactionStatus status);
  void send(const cfdp::Header& header, cfdp::Pdu pdu);

  CfdpReceiverSettings settings_;
  Send send_;
  Keep keep_;
  std::map<Key, Transaction> transactions_;
  std::map<Key, Closed> closed_;
  std::deque<Key> closed_order_;  ///< keys of `closed_`, oldest first
  std::uint64_t held_bytes_ = 0;
  CfdpReceiverCounts counts_;
};

}  // namespace ilp::ground_cfdp
