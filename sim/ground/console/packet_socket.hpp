// The ground's end of a packet link over UDP or TCP.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/posix/socket.hpp"

namespace ilp::console {

enum class Transport : std::uint8_t { udp, tcp };

class PacketSocket {
 public:
  using Bytes = std::vector<std::uint8_t>;

  /// Connects; from the address `local`, or the system chooses. std::runtime_error if no program listens there (TCP).
  PacketSocket(Transport transport, const SocketAddress& board, const SocketAddress& local = {});
  ~PacketSocket();
  PacketSocket(const PacketSocket&) = delete;
  PacketSocket& operator=(const PacketSocket&) = delete;

  /// One or more whole packets. std::runtime_error when the connection is gone.
  void send(std::span<const std::uint8_t> bytes);
  /// Everything that has come within `wait_ms`, or at once when something is there: datagrams as they are, a stream cut
  /// into space packets. Empty for nothing.
  std::vector<Bytes> receive(int wait_ms);
  /// The other side has ended a stream.
  [[nodiscard]] bool closed() const { return closed_; }
  /// The other machine has answered that no program listens at the address.
  [[nodiscard]] bool refused() const { return refused_; }

 private:
  Transport transport_;
  int socket_ = -1;
  bool closed_ = false, refused_ = false;
  Bytes stream_;
};

}  // namespace ilp::console
