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
/// The system's own queue: bounded, so that a client that does not read is noticed.
constexpr int system_queue_bytes = 256 * 1024;
// A client whose host has vanished is noticed after about ten seconds of silence and three questions.
constexpr int keepalive_s = 10;
constexpr int keepalive_interval_s = 3;
constexpr int keepalive_questions = 3;

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

void TcpLink::accept_clients(TimeNs now) {
  for (std::size_t i = 0; i < limits::max_tcp_clients; ++i) {
    const int socket = ::accept4(socket_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    admit(socket, now);
  }
}

void TcpLink::admit(int socket, TimeNs now) {
  auto place = std::find_if(clients_.begin(), clients_.end(), [](const Client& client) { return client.socket < 0; });
  if (place == clients_.end()) {
    place = std::find_if(clients_.begin(), clients_.end(), [](const Client& client) { return client.ended; });
  }
  if (place == clients_.end()) {
    ++counts_.turned_away;
    close_socket(socket);
    return;
  }
  close_socket(place->socket);
  ++counts_.accepted;
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, SOL_SOCKET, SO_SNDBUF, system_queue_bytes);
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, keepalive_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, keepalive_interval_s);
  set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, keepalive_questions);
  place->socket = socket;
  place->malformed = 0;
  place->ended = false;
  place->whole_ns = place->taken_ns = now;
  place->in_first = place->in_size = 0;
  place->out_first = place->out_size = 0;
}

void TcpLink::read(Client& client, TimeNs now) {
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
  const std::size_t length =
      waiting.size() < header_bytes ? header_bytes + 1 : header_bytes + 1U + ((waiting[4] << 8U) | waiting[5]);
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
  accept_clients(now);
  for (std::size_t i = 0; i < clients_.size(); ++i) {
    Client& client = clients_[(next_client_ + i) % clients_.size()];
    if (client.socket >= 0) flush(client, now);
    if (client.socket >= 0) read(client, now);
    std::span<const std::uint8_t> packet;
    if (client.socket < 0 || !next_packet(client, now, packet)) continue;
    // The others first next time.
    next_client_ = (next_client_ + i + 1) % clients_.size();
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

bool TcpLink::enqueue(Client& client, std::span<const std::uint8_t> packet) {
  if (client.out.size() - client.out_size < packet.size()) return false;
  if (client.out.size() - client.out_first - client.out_size < packet.size()) {
    std::memmove(client.out.data(), client.out.data() + client.out_first, client.out_size);
    client.out_first = 0;
  }
  std::copy(packet.begin(), packet.end(),
            client.out.begin() + static_cast<std::ptrdiff_t>(client.out_first + client.out_size));
  client.out_size += packet.size();
  return true;
}

Status TcpLink::send(std::span<const std::uint8_t> packet) {
  if (packet.size() > limits::tcp_queue_bytes) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size()),
            static_cast<std::int64_t>(limits::tcp_queue_bytes)};
  }
  const TimeNs now = clock_.now();
  std::uint32_t taken = 0, missed = 0;
  for (Client& client : clients_) {
    if (client.socket >= 0) flush(client, now);
    if (client.socket < 0) continue;
    if (enqueue(client, packet)) {
      ++taken;
      flush(client, now);
    } else {
      ++missed;
    }
  }
  if (taken == 0) return StatusCode::not_ready;
  counts_.skipped += missed;
  return {};
}

}  // namespace ilp
