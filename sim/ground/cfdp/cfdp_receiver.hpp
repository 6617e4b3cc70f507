// The ground's end of file delivery: receives files by CFDP class 2 (CCSDS 727.0-B-5, 4.6.4), written from the standard
// and independent of what flies. Any PDU may be forged: memory and time stay bounded.
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

// The received octets of a file, in any order, and the gaps between them. Memory and time depend on the received data,
// not on its place in the file.

class ReceivedSegments {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Keeps the octets from `offset` on that are not held yet; octets held before are not replaced. `offset` + size must
  /// be at most 2^63. Returns the number of new octets.
  std::uint64_t add(std::uint64_t offset, std::span<const std::uint8_t> bytes);

  /// True when [0, end) is held.
  [[nodiscard]] bool whole(std::uint64_t end) const;
  /// The gaps of [begin, end), in order, at most `most` of them.
  [[nodiscard]] std::vector<cfdp::Gap> gaps(std::uint64_t begin, std::uint64_t end, std::size_t most) const;
  /// The octets [0, end), which must be whole.
  [[nodiscard]] Bytes file(std::uint64_t end) const;

  /// Memory in bytes, the bookkeeping of each piece included.
  [[nodiscard]] std::uint64_t memory_bytes() const;

 private:
  std::map<std::uint64_t, Bytes> segments_;      ///< by their beginning; they do not overlap
  std::map<std::uint64_t, std::uint64_t> runs_;  ///< held without a gap: from, to
  std::uint64_t held_bytes_ = 0;
};

struct CfdpReceiverSettings {
  std::uint64_t entity = 2;
  double timer_s = 5;                       ///< a NAK or a Finished is sent again after this time
  int limit = 1000;                         ///< repetitions without an answer after which the transaction ends
  bool immediate_nak = true;                ///< a gap is requested when it is seen, not only after the EOF
  bool forget_data_before_metadata = true;  ///< file data before the metadata are dropped, as some receivers do
  std::size_t gaps_in_a_nak = 100;
  std::size_t gaps_at_once = 1000;  ///< requested in one NAK; the next NAK has the others
  std::uint64_t max_file_bytes = std::uint64_t{256} << 20U;
  /// Limits of open transactions and of their data. When a new transaction does not fit, the one that has been silent
  /// for longest is dropped; if its sender speaks again, the whole file is requested.
  std::size_t max_open = 256;
  std::uint64_t max_held_bytes = std::uint64_t{512} << 20U;
  /// Answers of ended transactions, for senders that repeat an EOF; the oldest is dropped first.
  std::size_t max_closed = 1024;
};

struct CfdpReceiverCounts {
  std::uint64_t pdus = 0, malformed = 0, not_for_us = 0;
  std::uint64_t files = 0, checksum_failures = 0, abandoned = 0;
  std::uint64_t data_bytes = 0;      ///< of files, repeated ones included
  std::uint64_t repeated_bytes = 0;  ///< octets that were held already
  std::uint64_t forgotten = 0;       ///< transactions that were dropped for others
  std::uint64_t restarted = 0;       ///< transactions whose number came again with another file
  std::uint64_t out_of_range = 0;    ///< data beyond the end of their file, or of any file
};

/// Times are seconds of any clock that never goes back.
///
/// Source and number identify a transaction. The answer of an ended transaction is kept, and a repeated EOF gets it
/// again. A number that comes again with other metadata, or with an EOF of another size or checksum, begins a new file:
/// data of the old one is not used.
class CfdpReceiver {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Send = std::function<void(const Bytes& pdu)>;
  /// Called with a complete file whose checksum is right; returns false when the file cannot be kept.
  using Keep = std::function<bool(const std::string& name, const Bytes& file)>;

  CfdpReceiver(CfdpReceiverSettings settings, Send send, Keep keep);

  void receive(std::span<const std::uint8_t> bytes, double now);
  void tick(double now);
  /// Ends all open transactions.
  void cancel_all(double now);

  [[nodiscard]] const CfdpReceiverCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t open() const { return transactions_.size(); }
  [[nodiscard]] std::size_t closed() const { return closed_.size(); }
  /// Memory of the files that are being received.
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
    std::uint64_t end = 0;  ///< end of the data received
    ReceivedSegments segments;
    bool finished = false;  ///< Finished has been sent, its ACK is expected
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
  std::deque<Key> closed_order_;  ///< of `closed_`, oldest first
  std::uint64_t held_bytes_ = 0;
  CfdpReceiverCounts counts_;
};

}  // namespace ilp::ground_cfdp
