// A ground station's end of a UDP or TCP socket, for tests. Receiving waits up to a limit.
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
  /// `receive_queue` is the size of the system's receive buffer, bytes; 0: the system's default.
  explicit TcpClient(const SocketAddress& board, int receive_queue = 0);
  ~TcpClient();
  TcpClient(const TcpClient&) = delete;
  TcpClient& operator=(const TcpClient&) = delete;
  /// Returns false if the other side has closed the connection.
  bool send(const Bytes& bytes);
  /// Returns `count` bytes, or fewer if none arrive for `wait_ms` or the other side has closed the connection.
  Bytes receive(std::size_t count, int wait_ms = 2000);
  /// Whether the other side closes the connection within `wait_ms`.
  bool closed(int wait_ms = 2000);
  /// Ends sending; receiving is still possible.
  void end_sending();
  /// Closes the connection with a reset.
  void vanish();

 private:
  int socket_ = -1;
};

}  // namespace ilp::test
