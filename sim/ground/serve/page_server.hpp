// The HTTP server of the live page.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "hal/posix/socket.hpp"
#include "sim/ground/serve/command_requests.hpp"
#include "sim/ground/serve/live_flight.hpp"

namespace ilp::serve {

/// Bounds of what clients can take.
struct ServerLimits {
  unsigned connections = 64;                 ///< a further one takes the place of another (ConnectionPlaces)
  std::size_t bytes_per_connection = 16384;  ///< for a request's line and headers together
  std::chrono::seconds request{10};          ///< within which a request is whole
  unsigned idle_s = 30;                      ///< after which a connection that takes nothing of its answer is closed
};

/// Answers GET and HEAD, everything else with a text that says what is wrong:
///   /             the page; /page/NAME its parts
///   /events       what changes, as server-sent events: `id` is the place, `data` an Update; after Last-Event-ID only
///                 what is new since. An event "alive" comes every 5 s
///   /state        everything as one Update
///   /map/NAME     a picture that an item names
///   /files/NAME   a file of the results, which a browser shows as a page of no origin
/// With `commands` (null: none) also what command_requests.hpp says. Every connection has a thread.
class PageServer {
 public:
  /// Throws std::runtime_error with a message for the user if it cannot listen there.
  PageServer(const SocketAddress& address, LiveFlight& flight, Commands* commands, const ServerLimits& limits = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// Where it listens, such as 127.0.0.1:8080.
  [[nodiscard]] std::string address() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace ilp::serve
