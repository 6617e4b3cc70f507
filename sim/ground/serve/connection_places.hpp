// Limits the connections of an HTTP server: chooses which one is closed for a new one, and closes slow ones.
#pragma once

#include <microhttpd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "hal/posix/socket.hpp"

namespace ilp::serve {

/// A new connection is always accepted. If the limit is reached, another one is closed: the oldest that is still
/// sending its request, else the oldest that is being answered, else the oldest that has shown the right token. A
/// connection is also closed if its request is not complete within `request` after its start or after the end of the
/// answer before, even if it keeps sending octets. May be used by several threads.
class ConnectionPlaces {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Standing : std::uint8_t { asks, answered, trusted };
  struct Connection {
    int socket = -1;
    SocketAddress local;                  ///< address of this server that the client connected to
    Clock::time_point begin, asks_since;  ///< start of the connection, and of its present request
    bool answering = false, trusted = false;
    std::atomic<bool> gone = false;  ///< it has been closed: a thread that waits for it ends
    [[nodiscard]] Standing standing() const {
      return trusted ? Standing::trusted : answering ? Standing::answered : Standing::asks;
    }
  };

  /// `places`: largest number of connections. `on_gone` is called after a connection was closed for a new one; it wakes
  /// threads that wait for a connection.
  ConnectionPlaces(unsigned places, std::chrono::milliseconds request, std::function<void()> on_gone);
  ~ConnectionPlaces();
  ConnectionPlaces(const ConnectionPlaces&) = delete;
  ConnectionPlaces& operator=(const ConnectionPlaces&) = delete;

  /// Connection limit for the library. It is larger, to allow for connections that are being closed.
  [[nodiscard]] unsigned library_limit() const { return 2 * places_ + 64; }
  /// Callback for MHD_OPTION_NOTIFY_CONNECTION; `self` is this object.
  static void on_connection(void* self, MHD_Connection* connection, void** context,
                            MHD_ConnectionNotificationCode code);
  [[nodiscard]] static Connection& of(MHD_Connection* connection);
  /// The connection has shown the right token.
  void trust(Connection& connection);
  /// The connection's request is complete.
  void answer(Connection& connection);
  /// The connection's request has been answered; another one may follow.
  void end_request(Connection& connection);

 private:
  void admit(MHD_Connection* connection, void** context);
  void remove(Connection* connection);
  void close(Connection& connection);
  /// Closes a connection if the limit is reached; returns whether it did.
  bool make_room();
  void watch();

  const unsigned places_;
  const std::chrono::milliseconds request_;
  const std::function<void()> on_gone_;
  std::mutex mutex_;
  std::condition_variable ending_;
  bool ended_ = false;
  std::vector<Connection*> connections_;
  std::thread watch_;
};

}  // namespace ilp::serve
