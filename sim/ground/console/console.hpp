// A small ground station: sends telecommands and files, and receives reports and files.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fsw/packets/authentication.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/tailoring.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "sim/ground/cfdp/cfdp_sender.hpp"
#include "sim/ground/console/packet_socket.hpp"
#include "sim/ground/console/station_numbers.hpp"

namespace ilp::console {

/// Time of a monotonic clock, seconds.
[[nodiscard]] inline double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct ConsoleSettings {
  Transport transport = Transport::udp;
  SocketAddress board;
  std::optional<SocketAddress> cfdp;  ///< the flight's address for bare PDUs; none: PDUs are in space packets
  SocketAddress cfdp_local;           ///< this station's address for bare PDUs
  std::uint16_t apid = 239;
  std::uint16_t source = 1;
  Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
  std::uint16_t spi = 0;  ///< 0: telecommands are not authenticated
  std::vector<std::uint8_t> key;
  bool seal_files =
      false;  ///< authenticate PDUs too, for a flight with `link.authentication` 2; not possible for bare PDUs
  std::uint32_t sequence = 0;               ///< last used sequence number, for a station without `numbers`
  std::shared_ptr<StationNumbers> numbers;  ///< source of sequence and transaction numbers; may be null
  bool take_files = true;                   ///< false: answer no PDU, because another station receives the files
  ground_cfdp::CfdpReceiver::Keep keep;     ///< stores a file before it is confirmed; empty: all files are accepted
  bool remember_files = true;               ///< keep files in memory too (Console::files)
};

/// A report of the package.
struct Report {
  Telemetry header;
  std::vector<std::uint8_t> data;
};

/// Splits received bytes into packets. Calls `report` for each report of the package, and `pdu` for the content of each
/// file packet. Returns the number of malformed or other packets.
std::size_t take_packets(std::span<const std::uint8_t> octets, std::uint16_t apid, const Tailoring& tailoring,
                         const std::function<void(Report)>& report,
                         const std::function<void(std::span<const std::uint8_t>)>& pdu);

class Console {
 public:
  using Bytes = std::vector<std::uint8_t>;

  explicit Console(ConsoleSettings settings);

  /// Builds a telecommand with the next sequence count without sending it, to be put into the schedule.
  Bytes build(std::uint8_t service, std::uint8_t subtype, const Bytes& data);
  /// Builds and sends a telecommand. Returns its request id: the first four octets of its header.
  std::uint32_t command(std::uint8_t service, std::uint8_t subtype, const Bytes& data);
  /// Sends octets unchanged.
  void send(const Bytes& octets) { socket_.send(octets); }
  /// Sends a file to the package, and returns its transaction number. Throws std::runtime_error if that is impossible.
  std::uint64_t put_file(const std::string& name, const Bytes& file);
  [[nodiscard]] const ground_cfdp::CfdpSender::Transfer& transfer(std::uint64_t sequence) const {
    return sender_->transfer(sequence);
  }
  /// Sets whether PDUs are authenticated from now on. Throws std::runtime_error if they cannot be authenticated.
  void seal_files(bool wanted);
  /// The request id of a telecommand's packet.
  [[nodiscard]] static std::uint32_t request_of(const Bytes& packet);

  /// Receives reports and files until `done` returns true, at most for `seconds`. Returns whether `done` returned true.
  bool listen(double seconds, const std::function<bool()>& done = {});

  [[nodiscard]] const std::vector<Report>& reports() const { return reports_; }
  /// Returns and removes all reports, so that memory does not grow in a station that runs for long.
  [[nodiscard]] std::vector<Report> take_reports() { return std::exchange(reports_, {}); }
  /// Subtypes of the reports of service 1 about a telecommand, in the order of their arrival.
  [[nodiscard]] std::vector<int> verification_of(std::uint32_t request) const;
  [[nodiscard]] bool completed(std::uint32_t request) const;
  [[nodiscard]] std::size_t count(std::uint8_t service, std::uint8_t subtype) const;
  [[nodiscard]] const std::map<std::string, Bytes>& files() const { return files_; }
  /// Whether the flight has closed the connection (TCP).
  [[nodiscard]] bool closed() const { return socket_.closed(); }
  [[nodiscard]] bool refused() const { return socket_.refused(); }
  [[nodiscard]] std::size_t malformed() const { return malformed_; }
  [[nodiscard]] const ground_cfdp::CfdpReceiver& cfdp() const { return *receiver_; }

 private:
  Bytes sealed(const Bytes& packet);
  void take(const Bytes& datagram);
  void take_pdu(std::span<const std::uint8_t> pdu);
  void send_pdu(const Bytes& pdu);

  ConsoleSettings settings_;
  PacketSocket socket_;
  std::unique_ptr<PacketSocket> cfdp_socket_;
  std::unique_ptr<ground_cfdp::CfdpReceiver> receiver_;
  std::unique_ptr<ground_cfdp::CfdpSender> sender_;
  std::uint16_t next_count_ = 0, next_pdu_count_ = 0;
  std::uint64_t next_transaction_ = 0;
  std::vector<Report> reports_;
  std::map<std::string, Bytes> files_;
  std::size_t malformed_ = 0;
};

}  // namespace ilp::console
