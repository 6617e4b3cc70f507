#include "hal/link/tcp/tcp_link.hpp"

#include <netinet/tcp.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "hal/posix/socket_address.hpp"

namespace ilp {
namespace {

constexpr std::size_t header_bytes = 6;
constexpr std::uint32_t most_malformed = 16;
/// The system's own queue is bounded, so that a client that does not read is detected.
constexpr int system_queue_bytes = 256 * 1024;
// A client whose host has vanished is detected after about ten seconds of silence and three probes.
constexpr int keepalive_s = 10;
constexpr int keepalive_interval_s = 3;
constexpr int keepalive_questions = 3;
// The same while telemetry is on its way to it.
constexpr int unanswered_ms = 20'000;

void set_option(int socket, int level, int option, int value) {
  // A socket without it works too.
  static_cast<void>(::setsockopt(socket, level, option, &value, sizeof(value)));
}

bool only_later(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}

bool version_is_right(std::uint8_t first) {
  return (first >> 5U) == 0;
}

}  // namespace

TcpLink::~TcpLink() {
  for (Client& client : clients_) close_socket(client.socket);
  close_socket(socket_);
}

Status TcpLink::open(const SocketAddress& local) {
  for (Client& client : clients_) close_socket(client.socket);
  close_socket(socket_);
  return open_socket(SocketKind::tcp, local, socket_);
}

std::size_t TcpLink::clients() const {
  return static_cast<std::size_t>(
      std::count_if(clients_.begin(), clients_.end(), [](const Client& client) { return client.socket >= 0; }));
}

void TcpLink::drop(Client& client, std::uint32_t& reason) {
  ++reason;
  close_socket(client.socket);
}

/// Accepts one client per call, so that each is read before the next one is accepted.
void TcpLink::accept_client(TimeNs now) {
  Client* const place = place_for_new();
  if (place == nullptr) return;
  const int socket = ::accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket >= 0) admit(socket, now, *place);
}

TcpLink::Client* TcpLink::place_for_new() {
  Client* place = nullptr;
  for (Client& client : clients_) {
    if (client.socket < 0) return &client;
    if (!client.read) continue;
    const auto rank = [](const Client& of) { return of.ended ? 0 : of.accepted ? 2 : 1; };
    const bool sooner = place == nullptr || rank(client) < rank(*place) ||
                        (rank(client) == rank(*place) && client.received < place->received);
    if (sooner) place = &client;
  }
  return place;
}

void TcpLink::admit(int socket, TimeNs now, Client& place) {
  if (place.socket >= 0) drop(place, counts_.gave_way);
  ++counts_.accepted;
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, SOL_SOCKET, SO_SNDBUF, system_queue_bytes);
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, keepalive_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, keepalive_interval_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, keepalive_questions);
  set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, unanswered_ms);
  place.socket = socket;
  place.malformed = 0;
  place.ended = place.accepted = place.read = false;
  place.received = ++order_;
  place.whole_ns = place.taken_ns = now;
  place.in_first = place.in_size = 0;
  place.out_first = place.out_size = 0;
}

void TcpLink::accept_sender() {
  Client& client = clients_[sender_];
  if (client.socket < 0) return;
  client.accepted = true;
  client.received = ++order_;
}

void TcpLink::read(Client& client, TimeNs now) {
  client.read = true;
  if (client.in_size == 0) {
    client.in_first = 0;
    client.whole_ns = now;
  } else if (client.in_first > 0 && client.in_first + client.in_size == client.in.size()) {
    std::memmove(client.in.data(), client.in.data() + client.in_first, client.in_size);
    client.in_first = 0;
  }
  const std::size_t end = client.in_first + client.in_size;
  if (end == client.in.size()) return;
  const ssize_t got = ::recv(client.socket, client.in.data() + end, client.in.size() - end, MSG_DONTWAIT);
  if (got > 0) {
    client.in_size += static_cast<std::size_t>(got);
  } else if (got == 0) {
    client.ended = true;
  } else if (!only_later(errno)) {
    close_socket(client.socket);
  }
}

/// Removes the packet from the queue; `packet` stays valid until the next read.
bool TcpLink::next_packet(Client& client, TimeNs now, std::span<const std::uint8_t>& packet) {
  const auto waiting = std::span<const std::uint8_t>(client.in).subspan(client.in_first, client.in_size);
  const std::size_t length = waiting.size() < header_bytes
                                 ? header_bytes + 1
                                 : header_bytes + 1 + (std::size_t{waiting[4]} << 8U | waiting[5]);
  if (waiting.empty()) return false;
  const bool whole = waiting.size() >= length;
  const bool followed = waiting.size() == length || (whole && version_is_right(waiting[length]));
  if (version_is_right(waiting[0])) {
    client.malformed = 0;
  } else if (!followed || ++client.malformed > most_malformed) {
    drop(client, counts_.garbage);
    return false;
  }
  if (!whole) {
    if (client.ended || now - client.whole_ns > patience_ns) drop(client, counts_.garbage);
    return false;
  }
  packet = waiting.first(length);
  client.in_first += length;
  client.in_size -= length;
  client.whole_ns = now;
  return true;
}

Status TcpLink::receive(std::span<std::uint8_t> buffer, std::size_t& bytes) {
  bytes = 0;
  const TimeNs now = clock_.now();
  accept_client(now);
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    Client& client = clients_[(next_client_ + i) % clients_.size()];
    if (client.socket >= 0) flush(client, now);
    if (client.socket >= 0) read(client, now);
    std::span<const std::uint8_t> packet;
    if (client.socket < 0 || !next_packet(client, now, packet)) continue;
    sender_ = (next_client_ + i) % clients_.size();
    // The next call begins with the other clients.
    next_client_ = (sender_ + 1) % clients_.size();
    if (packet.size() > buffer.size()) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size()),
              static_cast<std::int64_t>(buffer.size())};
    }
    std::copy(packet.begin(), packet.end(), buffer.begin());
    bytes = packet.size();
    return {};
  }
  return StatusCode::not_ready;
}

void TcpLink::flush(Client& client, TimeNs now) {
  if (client.out_size == 0) {
    client.taken_ns = now;
    return;
  }
  const ssize_t sent =
      ::send(client.socket, client.out.data() + client.out_first, client.out_size, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (sent > 0) {
    client.taken_ns = now;
    client.out_first += static_cast<std::size_t>(sent);
    client.out_size -= static_cast<std::size_t>(sent);
    if (client.out_size == 0) client.out_first = 0;
  } else if (sent < 0 && !only_later(errno)) {
    close_socket(client.socket);
  } else if (now - client.taken_ns > patience_ns) {
    drop(client, counts_.unread);
  }
}

bool TcpLink::has_capacity(const Client& client, std::span<const std::uint8_t> packet) {
  return client.socket >= 0 && client.out.size() - client.out_size >= packet.size();
}

void TcpLink::enqueue(Client& client, std::span<const std::uint8_t> packet) {
  if (client.out.size() - client.out_first - client.out_size < packet.size()) {
    std::memmove(client.out.data(), client.out.data() + client.out_first, client.out_size);
    client.out_first = 0;
  }
  std::copy(packet.begin(), packet.end(),
            client.out.begin() + static_cast<std::ptrdiff_t>(client.out_first + client.out_size));
  client.out_size += packet.size();
}

Status TcpLink::send(std::span<const std::uint8_t> packet) {
  if (packet.size() > limits::tcp_queue_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size()),
            static_cast<std::int64_t>(limits::tcp_queue_bytes)};
  }
  const TimeNs now = clock_.now();
  bool operated = false;
  for (Client& client : clients_) {
    if (client.socket >= 0) flush(client, now);
    operated = operated || (client.socket >= 0 && client.accepted);
  }
  // If the packet does not count as sent no client gets it, because it will be sent again.
  const auto counts = [&](const Client& client) {
    return has_capacity(client, packet) && (client.accepted || !operated);
  };
  if (std::none_of(clients_.begin(), clients_.end(), counts)) return StatusCode::not_ready;
  for (Client& client : clients_) {
    if (client.socket < 0) continue;
    if (!has_capacity(client, packet)) {
      ++counts_.skipped;
      continue;
    }
    enqueue(client, packet);
    flush(client, now);
  }
  return {};
}

}  // namespace ilp
