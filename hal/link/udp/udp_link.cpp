#include "hal/link/udp/udp_link.hpp"

#include <cerrno>

#include "hal/posix/socket_address.hpp"

namespace ilp {

UdpLink::~UdpLink() {
  close_socket(socket_);
}

Status UdpLink::open(const SocketAddress& local, const SocketAddress* peer) {
  close_socket(socket_);
  stations_ = {};
  fixed_ = peer != nullptr;
  if (fixed_) stations_[0] = {*peer, 0, true};
  return open_socket(SocketKind::udp, local, socket_);
}

Status UdpLink::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  bytes = 0;
  sockaddr_in sender{};
  socklen_t size = sizeof(sender);
  // With MSG_TRUNC the true length comes back, however small the buffer.
  const ssize_t length =
      ::recvfrom(socket_, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC, general(&sender), &size);
  if (length < 0) {
    const bool nothing = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR || errno == ECONNREFUSED;
    return nothing ? Status{StatusCode::not_ready} : Status{StatusCode::io_error, errno};
  }
  sender_ = address_of(sender);
  bytes = static_cast<std::size_t>(length);
  if (bytes <= buffer.size()) return {};
  return {StatusCode::capacity_exceeded, length, static_cast<std::int64_t>(buffer.size())};
}

bool UdpLink::listening(const Station& station, TimeNs now) const {
  return station.used && (fixed_ || now - station.received_ns <= station_lifetime_ns);
}

Status UdpLink::send(std::span<const std::uint8_t> packet) {
  const TimeNs now = clock_.now();
  Status result = StatusCode::not_ready;
  for (const Station& station : stations_) {
    if (!listening(station, now)) continue;
    const sockaddr_in to = system_address(station.address);
    const ssize_t sent =
        ::sendto(socket_, packet.data(), packet.size(), MSG_DONTWAIT | MSG_NOSIGNAL, general(&to), sizeof(to));
    if (sent >= 0) {
      result = {};
    } else if (errno == EMSGSIZE && !result.ok()) {
      result = {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size())};
    }
  }
  return result;
}

void UdpLink::accept_sender() {
  if (fixed_) return;
  const TimeNs now = clock_.now();
  Station* place = &stations_[0];
  for (Station& station : stations_) {
    if (station.used && station.address == sender_) {
      station.received_ns = now;
      return;
    }
    if (place->used && (!station.used || station.received_ns < place->received_ns)) place = &station;
  }
  *place = {sender_, now, true};
}

}  // namespace ilp
