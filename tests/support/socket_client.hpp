// A ground station's end of a socket, for tests: waits as long as it must, with a bound against hanging.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "hal/posix/socket.hpp"

namespace ilp::test {

using Bytes = std::vector<std::uint8_t>;

inline constexpr SocketAddress any_port{0x7F000001, 0};

class UdpClient {
 public:
  explicit UdpClient(const SocketAddress& board);
  ~UdpClient();
  UdpClient(const UdpClient&) = delete;
  UdpClient& operator=(const UdpClient&) = delete;
  void send(const Bytes& datagram);
  std::optional<Bytes> receive(int wait_ms = 2000);
  [[nodiscard]] SocketAddress address() const;

 private:
  SocketAddress board_;
  int socket_ = -1;
};

class TcpClient {
 public:
  /// `receive_queue`: bytes that the system keeps for a client that does not read; 0: as usual.
  explicit TcpClient(const SocketAddress& board, int receive_queue = 0);
  ~TcpClient();
  TcpClient(const TcpClient&) = delete;
  TcpClient& operator=(const TcpClient&) = delete;
  /// False when the other side has closed.
  bool send(const Bytes& bytes);
  /// Exactly `count` bytes; fewer when none come for `wait_ms` or the other side has closed.
  Bytes receive(std::size_t count, int wait_ms = 2000);
  /// The other side has closed the connection.
  bool closed(int wait_ms = 2000);
  void end_sending();
  /// Closes with a reset instead of in good order.
  void vanish();

 private:
  int socket_ = -1;
};

}  // namespace ilp::test
