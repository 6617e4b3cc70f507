// Converts between SocketAddress and the system's sockaddr_in.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "hal/posix/socket.hpp"

namespace ilp {

inline sockaddr_in system_address(const SocketAddress& address) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_addr.s_addr = htonl(address.host);
  out.sin_port = htons(address.port);
  return out;
}

inline SocketAddress address_of(const sockaddr_in& address) {
  return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)};
}

/// Casts an address to the general type that the system calls take.
inline sockaddr* general(sockaddr_in* address) {
  return reinterpret_cast<sockaddr*>(address);
}
inline const sockaddr* general(const sockaddr_in* address) {
  return reinterpret_cast<const sockaddr*>(address);
}

}  // namespace ilp
