// The places for connections of an HTTP server: who gives way to a new connection, and how long a request may take.
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

/// A new connection always gets a place. When all are taken, one is closed: the oldest of those that ask, else of those
/// that are answered, else of those that have shown the right token. A connection that has no whole request within
/// `request` of its begin, or of the end of the answer before, is closed, however often it sends an octet. May be used
/// by several threads.
class ConnectionPlaces {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Standing : std::uint8_t { asks, answered, trusted };
  struct Connection {
    int socket = -1;
    SocketAddress local;  ///< at which it came
    Clock::time_point begin, asks_since;
    bool answering = false, trusted = false;
    std::atomic<bool> gone = false;  ///< it has given way: whoever waits for it ends
    [[nodiscard]] Standing standing() const {
      return trusted ? Standing::trusted : answering ? Standing::answered : Standing::asks;
    }
  };

  /// `on_gone` wakes threads that wait for a connection, after it has given way.
  ConnectionPlaces(unsigned places, std::chrono::milliseconds request, std::function<void()> on_gone);
  ~ConnectionPlaces();
  ConnectionPlaces(const ConnectionPlaces&) = delete;
  ConnectionPlaces& operator=(const ConnectionPlaces&) = delete;

  /// For the library: more than the places, for the connections that are just being closed.
  [[nodiscard]] unsigned library_limit() const { return 2 * places_ + 64; }
  /// MHD_OPTION_NOTIFY_CONNECTION with this object.
  static void on_connection(void* self, MHD_Connection* connection, void** context,
                            MHD_ConnectionNotificationCode code);
  [[nodiscard]] static Connection& of(MHD_Connection* connection);
  void trust(Connection& connection);
  /// Its request is whole.
  void answer(Connection& connection);
  /// Its request is over; it may make another one.
  void end_request(Connection& connection);

 private:
  void admit(MHD_Connection* connection, void** context);
  void remove(Connection* connection);
  void close(Connection& connection);
  /// Whether a connection gave way.
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
