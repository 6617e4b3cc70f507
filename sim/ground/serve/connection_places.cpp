#include "sim/ground/serve/connection_places.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <tuple>
#include <utility>

namespace ilp::serve {

ConnectionPlaces::ConnectionPlaces(unsigned places, std::chrono::milliseconds request, std::function<void()> on_gone)
    : places_(places), request_(request), on_gone_(std::move(on_gone)), watch_([this] { watch(); }) {}

ConnectionPlaces::~ConnectionPlaces() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  ending_.notify_all();
  watch_.join();
}

void ConnectionPlaces::on_connection(void* self, MHD_Connection* connection, void** context,
                                     MHD_ConnectionNotificationCode code) {
  auto& places = *static_cast<ConnectionPlaces*>(self);
  if (code == MHD_CONNECTION_NOTIFY_STARTED) return places.admit(connection, context);
  places.remove(static_cast<Connection*>(*context));
  *context = nullptr;
}

ConnectionPlaces::Connection& ConnectionPlaces::of(MHD_Connection* connection) {
  return *static_cast<Connection*>(
      MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context);
}

void ConnectionPlaces::admit(MHD_Connection* connection, void** context) {
  auto admitted = std::make_unique<Connection>();
  admitted->socket = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
  (void)local_address(admitted->socket, admitted->local);
  admitted->begin = admitted->asks_since = Clock::now();
  bool gave_way = false;
  {
    const std::lock_guard lock(mutex_);
    gave_way = make_room();
    connections_.push_back(admitted.get());
  }
  *context = admitted.release();
  if (gave_way) on_gone_();
}

// The library closes the socket after this, so that no number of a socket is used again while it is listed here.
void ConnectionPlaces::remove(Connection* connection) {
  const std::lock_guard lock(mutex_);
  std::erase(connections_, connection);
  delete connection;
}

// Its thread finds the end of the connection and ends it.
void ConnectionPlaces::close(Connection& connection) {
  connection.gone = true;
  (void)::shutdown(connection.socket, SHUT_RDWR);
}

bool ConnectionPlaces::make_room() {
  const auto open = std::count_if(connections_.begin(), connections_.end(),
                                  [](const Connection* connection) { return !connection->gone; });
  if (open < static_cast<std::ptrdiff_t>(places_)) return false;
  const auto sooner = [](const Connection* a, const Connection* b) {
    return std::make_tuple(a->gone.load(), a->standing(), a->begin) <
           std::make_tuple(b->gone.load(), b->standing(), b->begin);
  };
  close(**std::min_element(connections_.begin(), connections_.end(), sooner));
  return true;
}

void ConnectionPlaces::trust(Connection& connection) {
  const std::lock_guard lock(mutex_);
  connection.trusted = true;
}

void ConnectionPlaces::answer(Connection& connection) {
  const std::lock_guard lock(mutex_);
  connection.answering = true;
}

void ConnectionPlaces::end_request(Connection& connection) {
  const std::lock_guard lock(mutex_);
  connection.answering = false;
  connection.asks_since = Clock::now();
}

void ConnectionPlaces::watch() {
  std::unique_lock lock(mutex_);
  while (!ending_.wait_for(lock, request_ / 10, [&] { return ended_; })) {
    const Clock::time_point latest = Clock::now() - request_;
    for (Connection* connection : connections_) {
      if (!connection->gone && !connection->answering && connection->asks_since < latest) close(*connection);
    }
  }
}

}  // namespace ilp::serve
