// The ground's end of file delivery: receives files by CFDP class 2 (CCSDS 727.0-B-5, 4.6.4), written from the standard
// and independent of what flies.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "fsw/link/cfdp_pdu.hpp"

namespace ilp::sim {

struct CfdpReceiverSettings {
  std::uint64_t entity = 2;
  double timer_s = 5;                       ///< a NAK or a Finished goes again
  int limit = 1000;                         ///< so often without news; then the transaction ends
  bool immediate_nak = true;                ///< a gap is asked for when it is seen, not only behind the EOF
  bool forget_data_before_metadata = true;  ///< as some receivers do
  std::size_t gaps_in_a_nak = 100;
};

struct CfdpReceiverCounts {
  std::uint64_t pdus = 0, malformed = 0, not_for_us = 0;
  std::uint64_t files = 0, checksum_failures = 0, given_up = 0;
  std::uint64_t data_bytes = 0;      ///< of files, repeated ones included
  std::uint64_t repeated_bytes = 0;  ///< that were there already
};

/// Time is in seconds of any clock that runs.
class CfdpReceiver {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Send = std::function<void(const Bytes& pdu)>;
  /// A file is whole and has its checksum; false when it cannot be kept.
  using Keep = std::function<bool(const std::string& name, const Bytes& file)>;

  CfdpReceiver(CfdpReceiverSettings settings, Send send, Keep keep);

  void receive(std::span<const std::uint8_t> bytes, double now);
  void tick(double now);
  /// Ends every transaction that is open, as an operator may.
  void cancel_all(double now);

  [[nodiscard]] const CfdpReceiverCounts& counts() const { return counts_; }
  [[nodiscard]] std::size_t open() const;

 private:
  struct Transaction {
    cfdp::Header header;
    bool metadata = false;
    std::string name;
    std::uint8_t checksum_type = 0;
    bool eof = false;
    std::uint32_t checksum = 0;
    std::uint64_t file_bytes = 0;
    std::uint64_t end = 0;  ///< of the data that came
    Bytes file;
    std::vector<bool> held;
    bool finished = false;  ///< Finished has gone, its ACK is waited for
    bool closed = false;
    cfdp::Finished answer;
    double next_s = 0;
    int repeats = 0;
  };
  using Key = std::pair<std::uint64_t, std::uint64_t>;

  void hear_metadata(Transaction& t, const cfdp::Metadata& metadata);
  void hear_data(Transaction& t, const cfdp::FileData& data, double now);
  void hear_eof(Transaction& t, const cfdp::EndOfFile& eof, double now);
  void finish(Transaction& t, cfdp::Condition condition, cfdp::FileStatus status, double now);
  void complete_if_whole(Transaction& t, double now);
  void send_naks(const Transaction& t, std::uint64_t from);
  void send(const Transaction& t, cfdp::Pdu pdu);
  [[nodiscard]] std::vector<cfdp::Gap> gaps(const Transaction& t, std::uint64_t from) const;

  CfdpReceiverSettings settings_;
  Send send_;
  Keep keep_;
  std::map<Key, Transaction> transactions_;
  CfdpReceiverCounts counts_;
};

}  // namespace ilp::sim
