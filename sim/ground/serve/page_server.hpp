// The HTTP server of the live page.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "hal/posix/socket.hpp"
#include "sim/ground/serve/command_requests.hpp"
#include "sim/ground/serve/live_flight.hpp"

namespace ilp::serve {

/// Limits for clients.
struct ServerLimits {
  unsigned connections = 64;                 ///< a further one closes another (ConnectionPlaces)
  std::size_t bytes_per_connection = 16384;  ///< size of a request's line and headers together
  std::chrono::seconds request{10};          ///< time in which a request must be complete
  unsigned idle_s = 30;                      ///< time after which a client that does not read its answer is closed
};

/// Answers GET and HEAD requests for these paths, and others with a text that says what is wrong:
///   /             the page; /page/NAME its files
///   /events       changes as server-sent events: `id` is the Place, `data` the JSON of an Update. With Last-Event-ID
///   it
///                 begins with the changes since that Place. An event "alive" comes every 5 s
///   /state        the whole state as one Update
///   /map/NAME     a picture that an item names
///   /files/NAME   a file of the results; the browser treats it as a page without an origin
/// With `commands` (may be null) it also answers the requests of command_requests.hpp. Every connection has a thread.
class PageServer {
 public:
  /// Starts the server. Throws std::runtime_error with a message for the user if it cannot listen at `address`.
  PageServer(const SocketAddress& address, LiveFlight& flight, Commands* commands, const ServerLimits& limits = {});
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  /// The bound address, such as 127.0.0.1:8080.
  [[nodiscard]] std::string address() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace ilp::serve
