#include "hal/posix/socket.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "hal/posix/socket_address.hpp"

namespace ilp {
namespace {

constexpr int waiting_clients = 32;

bool parse_port(const char* text, std::uint16_t& port) {
  std::uint32_t value = 0;
  std::size_t digits = 0;
  for (; digits < 5 && text[digits] >= '0' && text[digits] <= '9'; ++digits) {
    value = 10 * value + static_cast<std::uint32_t>(text[digits] - '0');
  }
  if (digits == 0 || text[digits] != 0 || value > 65535) return false;
  port = static_cast<std::uint16_t>(value);
  return true;
}

Status bind_it(SocketKind kind, const SocketAddress& local, int socket) {
  const int on = 1;
  // A restarted program may listen at once.
  if (kind == SocketKind::tcp && ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on)) != 0) {
    return {StatusCode::io_error, errno};
  }
  const sockaddr_in address = system_address(local);
  if (::bind(socket, general(&address), sizeof(address)) != 0) return {StatusCode::io_error, errno};
  if (kind == SocketKind::tcp && ::listen(socket, waiting_clients) != 0) return {StatusCode::io_error, errno};
  return {};
}

}  // namespace

Status parse_address(const char* text, SocketAddress& address) {
  const char* colon = std::strrchr(text, ':');
  char host[INET_ADDRSTRLEN] = {};
  if (colon == nullptr || static_cast<std::size_t>(colon - text) >= sizeof(host)) return StatusCode::parse_error;
  std::memcpy(host, text, static_cast<std::size_t>(colon - text));
  in_addr parsed{};
  SocketAddress result;
  if (::inet_pton(AF_INET, host, &parsed) != 1 || !parse_port(colon + 1, result.port)) {
    return StatusCode::parse_error;
  }
  result.host = ntohl(parsed.s_addr);
  address = result;
  return {};
}

Status open_socket(SocketKind kind, const SocketAddress& local, int& socket) {
  const int type = kind == SocketKind::udp ? SOCK_DGRAM : SOCK_STREAM;
  int opened = ::socket(AF_INET, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (opened < 0) return {StatusCode::io_error, errno};
  const Status status = bind_it(kind, local, opened);
  if (!status.ok()) {
    close_socket(opened);
    return status;
  }
  socket = opened;
  return {};
}

Status local_address(int socket, SocketAddress& address) {
  sockaddr_in bound{};
  socklen_t size = sizeof(bound);
  if (::getsockname(socket, general(&bound), &size) != 0) return {StatusCode::io_error, errno};
  address = address_of(bound);
  return {};
}

void close_socket(int& socket) {
  if (socket >= 0) ::close(socket);
  socket = -1;
}

}  // namespace ilp
