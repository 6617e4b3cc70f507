#include "tests/support/socket_client.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <string>

#include "hal/posix/socket_address.hpp"

namespace ilp::test {
namespace {

bool readable(int socket, int wait_ms) {
  pollfd wanted{socket, POLLIN, 0};
  return ::poll(&wanted, 1, wait_ms) == 1;
}

void need(bool good, const char* what) {
  if (!good) throw std::runtime_error(std::string(what) + ": errno " + std::to_string(errno));
}

}  // namespace

UdpClient::UdpClient(const SocketAddress& board) : board_(board) {
  need(open_socket(SocketKind::udp, any_port, socket_).ok(), "opening a UDP socket");
}
UdpClient::~UdpClient() {
  close_socket(socket_);
}

void UdpClient::send(const Bytes& datagram) {
  const sockaddr_in to = system_address(board_);
  need(::sendto(socket_, datagram.data(), datagram.size(), 0, general(&to), sizeof(to)) >= 0, "sending a datagram");
}

std::optional<Bytes> UdpClient::receive(int wait_ms) {
  Bytes datagram(65536);
  if (!readable(socket_, wait_ms)) return {};
  const ssize_t size = ::recv(socket_, datagram.data(), datagram.size(), 0);
  if (size < 0) return {};
  datagram.resize(static_cast<std::size_t>(size));
  return datagram;
}

SocketAddress UdpClient::address() const {
  SocketAddress local;
  need(local_address(socket_, local).ok(), "own address");
  return local;
}

TcpClient::TcpClient(const SocketAddress& board, int receive_queue) {
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (receive_queue > 0) ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_queue, sizeof(receive_queue));
  const sockaddr_in to = system_address(board);
  need(::connect(socket_, general(&to), sizeof(to)) == 0, "connecting");
}
TcpClient::~TcpClient() {
  close_socket(socket_);
}

bool TcpClient::send(const Bytes& bytes) {
  return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

Bytes TcpClient::receive(std::size_t count, int wait_ms) {
  Bytes bytes(count);
  std::size_t have = 0;
  while (have < count && readable(socket_, wait_ms)) {
    const ssize_t got = ::recv(socket_, bytes.data() + have, count - have, 0);
    if (got <= 0) break;
    have += static_cast<std::size_t>(got);
  }
  bytes.resize(have);
  return bytes;
}

bool TcpClient::closed(int wait_ms) {
  std::uint8_t byte = 0;
  return readable(socket_, wait_ms) && ::recv(socket_, &byte, 1, MSG_PEEK) <= 0;
}

void TcpClient::end_sending() {
  ::shutdown(socket_, SHUT_WR);
}

void TcpClient::vanish() {
  const linger at_once{1, 0};
  ::setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof(at_once));
  close_socket(socket_);
}

}  // namespace ilp::test
