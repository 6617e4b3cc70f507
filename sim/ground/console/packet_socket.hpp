// Sends and receives packets on the ground over UDP or TCP.
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

  /// Connects to `board`. `local`: own address; by default the system chooses it. Throws std::runtime_error if no
  /// program listens at `board` (TCP).
  PacketSocket(Transport transport, const SocketAddress& board, const SocketAddress& local = {});
  ~PacketSocket();
  PacketSocket(const PacketSocket&) = delete;
  PacketSocket& operator=(const PacketSocket&) = delete;

  /// Sends one or more whole packets. Throws std::runtime_error if the connection has ended.
  void send(std::span<const std::uint8_t> bytes);
  /// Returns everything that has come, and waits for it at most `wait_ms`: datagrams unchanged, a stream split into
  /// space packets. Empty if nothing has come.
  std::vector<Bytes> receive(int wait_ms);
  /// Whether the other side has ended the stream.
  [[nodiscard]] bool closed() const { return closed_; }
  /// Whether the other machine has answered that no program listens at the address.
  [[nodiscard]] bool refused() const { return refused_; }

 private:
  Transport transport_;
  int socket_ = -1;
  bool closed_ = false, refused_ = false;
  Bytes stream_;
};

}  // namespace ilp::console
