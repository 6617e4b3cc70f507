// Sockets that never block, bound to one address only.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// IPv4.
struct SocketAddress {
  std::uint32_t host = 0;  ///< 127.0.0.1 is 0x7F000001
  std::uint16_t port = 0;

  friend bool operator==(const SocketAddress&, const SocketAddress&) = default;
};

/// `ADDRESS:PORT`, the address as four numbers. `parse_error` for anything else.
Status parse_address(const char* text, SocketAddress& address);

enum class SocketKind : std::uint8_t { udp, tcp };

/// Bound, and for TCP listening. Port 0 lets the system choose. `io_error` with errno.
Status open_socket(SocketKind kind, const SocketAddress& local, int& socket);
/// The address that a socket is bound to.
Status local_address(int socket, SocketAddress& address);
/// Closes the socket and sets it to -1. A value of -1 is left alone.
void close_socket(int& socket);

}  // namespace ilp
