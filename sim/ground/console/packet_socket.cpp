#include "sim/ground/console/packet_socket.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include "fsw/packets/space_packet.hpp"
#include "hal/posix/socket_address.hpp"

namespace ilp::console {
namespace {

constexpr std::size_t largest_datagram = 65536;
/// The station takes at most this many packets at a time, so that a flood does not keep it from its other work.
constexpr std::size_t most_at_once = 1000;

[[noreturn]] void fail(const char* what) {
  const bool refused = errno == ECONNREFUSED;
  throw std::runtime_error(
      std::string(what) + ": " + std::strerror(errno) +
      (refused ? "; start the flight with this address (--link-tcp), or correct the address" : ""));
}

}  // namespace

PacketSocket::PacketSocket(Transport transport, const SocketAddress& board, const SocketAddress& local)
    : transport_(transport) {
  socket_ = ::socket(AF_INET, (transport == Transport::udp ? SOCK_DGRAM : SOCK_STREAM) | SOCK_CLOEXEC, 0);
  const sockaddr_in address = system_address(board);
  const sockaddr_in own = system_address(local);
  if (socket_ < 0 || ::bind(socket_, general(&own), sizeof(own)) != 0 ||
      ::connect(socket_, general(&address), sizeof(address)) != 0) {
    const int error = errno;
    close_socket(socket_);
    errno = error;
    fail("connecting to the flight");
  }
}

PacketSocket::~PacketSocket() {
  close_socket(socket_);
}

void PacketSocket::send(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    // At the moment no program listens there or no route exists. The datagram is lost, as any datagram may be.
    const bool passes =
        errno == ECONNREFUSED || errno == ENETUNREACH || errno == EHOSTUNREACH || errno == ENOBUFS || errno == ENETDOWN;
    if (sent < 0 && errno == ECONNREFUSED) refused_ = true;
    if (sent < 0 && transport_ == Transport::udp && passes) return;
    if (sent < 0) fail("sending to the flight");
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

std::vector<PacketSocket::Bytes> PacketSocket::receive(int wait_ms) {
  std::vector<Bytes> packets;
  Bytes buffer(largest_datagram);
  pollfd wanted{socket_, POLLIN, 0};
  while (packets.size() < most_at_once && ::poll(&wanted, 1, packets.empty() ? wait_ms : 0) == 1) {
    const ssize_t size = ::recv(socket_, buffer.data(), buffer.size(), 0);
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) {
      if (size < 0 && errno == ECONNREFUSED) refused_ = true;
      // An earlier datagram was refused, or this one is empty. More may be waiting.
      closed_ = transport_ == Transport::tcp;
      break;
    }
    if (transport_ == Transport::udp) {
      packets.emplace_back(buffer.begin(), buffer.begin() + size);
      continue;
    }
    stream_.insert(stream_.end(), buffer.begin(), buffer.begin() + size);
    std::span<const std::uint8_t> packet;
    while (first_packet(stream_, packet).ok()) {
      packets.emplace_back(packet.begin(), packet.end());
      stream_.erase(stream_.begin(), stream_.begin() + static_cast<std::ptrdiff_t>(packets.back().size()));
    }
    // The rest of the packet will come soon.
    if (packets.empty()) wait_ms = std::min(wait_ms, 100);
  }
  return packets;
}

}  // namespace ilp::console
