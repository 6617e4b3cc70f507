// Opens non-blocking UDP and TCP sockets over IPv4, bound to one local address.
#pragma once

#include <cstdint>

#include "fsw/base/status.hpp"

namespace ilp {

/// An IPv4 address and port, in the byte order of the board.
struct SocketAddress {
  std::uint32_t host = 0;  ///< 127.0.0.1 is 0x7F000001
  std::uint16_t port = 0;

  friend bool operator==(const SocketAddress&, const SocketAddress&) = default;
};

/// Parses `ADDRESS:PORT`, where ADDRESS has four decimal numbers. Returns `parse_error` for other text.
Status parse_address(const char* text, SocketAddress& address);

enum class SocketKind : std::uint8_t { udp, tcp };

/// Opens a socket and binds it to `local`; a TCP socket listens. With port 0 the system chooses the port. Returns
/// `io_error` (first value: errno) on failure; `socket` is then unchanged.
Status open_socket(SocketKind kind, const SocketAddress& local, int& socket);
/// Reads the address to which a socket is bound.
Status local_address(int socket, SocketAddress& address);
/// Closes the socket and sets it to -1. Does nothing if it is negative.
void close_socket(int& socket);

}  // namespace ilp
