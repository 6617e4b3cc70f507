// Sends files from the ground to the package by CFDP class 2. Written from the standard, independently of the flight
// software.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "fsw/packets/cfdp_pdu.hpp"

namespace ilp::ground_cfdp {

struct CfdpSenderSettings {
  std::uint64_t entity = 2, destination = 1;
  std::uint8_t id_length = 2, sequence_length = 2;  ///< octets
  std::uint8_t checksum_type = 3;                   ///< 0 (modular) or 3 (CRC-32)
  bool crc = false;
  std::size_t segment_bytes = 500;
  double timer_s = 5;
  int limit = 1000;
};

class CfdpSender {
 public:
  using Bytes = std::vector<std::uint8_t>;
  using Send = std::function<void(const Bytes& pdu)>;

  enum class State { going, retained, failed };
  struct Transfer {
    cfdp::Header header;
    std::string name;
    Bytes file;
    bool eof_acknowledged = false;
    State state = State::going;
    cfdp::Condition condition = cfdp::Condition::no_error;
    cfdp::FileStatus file_status = cfdp::FileStatus::unreported;
    double next_s = 0;
    int repeats = 0;
  };

  CfdpSender(CfdpSenderSettings settings, Send send) : settings_(settings), send_(std::move(send)) {}

  /// Sends all PDUs of the file once, and returns the sequence number of the transaction.
  std::uint64_t put(const std::string& name, const Bytes& file, double now) {
    return put(name, file, now, sequence_ + 1);
  }
  /// The same with a sequence number of the caller, which must not have been used.
  std::uint64_t put(const std::string& name, const Bytes& file, double now, std::uint64_t sequence);
  void receive(std::span<const std::uint8_t> bytes, double now);
  void tick(double now);
  /// The state of a transaction that put() has begun.
  [[nodiscard]] const Transfer& transfer(std::uint64_t sequence) const { return transfers_.at(sequence); }

 private:
  void send(const cfdp::Header& header, cfdp::Pdu pdu);
  void send_metadata(const Transfer& transfer);
  void send_again(const Transfer& transfer, const cfdp::Pdu& pdu);
  void send_data(const Transfer& transfer, std::uint64_t begin, std::uint64_t end);
  void send_eof(const Transfer& transfer);

  CfdpSenderSettings settings_;
  Send send_;
  std::uint64_t sequence_ = 0;
  std::map<std::uint64_t, Transfer> transfers_;
};

}  // namespace ilp::ground_cfdp
