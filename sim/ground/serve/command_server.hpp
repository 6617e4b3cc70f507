// The HTTP server of the page of commands.
#pragma once

#include <chrono>
#include <memory>
#include <string>

#include "hal/posix/socket.hpp"
#include "sim/ground/serve/command_queue.hpp"
#include "sim/ground/serve/token_guard.hpp"

namespace ilp::serve {

/// Bounds of what clients can take.
struct CommandLimits {
  unsigned connections = 64;                 ///< a further one takes the place of another (ConnectionPlaces)
  std::size_t bytes_per_connection = 16384;  ///< for a request's line and headers together
  std::size_t body_bytes = 2048;
  std::chrono::seconds request{10};  ///< within which a request is whole
  unsigned idle_s = 30;              ///< after which a connection that takes nothing of its answer is closed
};

/// Answers:
///   /                   the page, and /page/NAME its parts: without a token, because they show nothing of the flight
///   POST /commands      {"line":TEXT}: sends a telecommand; 200 with the line as it was understood, or a text that
///   says
///                       why nothing was sent
///   /reports?after=     what CommandQueue::reports gives; waits at most 5 s
///   /help, /complete?typed=TEXT    lists of texts, as the console has them
/// All but the page need the header "Authorization: Bearer TOKEN". There are no cookies, and a POST needs the header
/// "Origin" with this server's own address, so that no page of another site can send a command. Every connection has a
/// thread.
class CommandServer {
 public:
  /// Throws std::runtime_error with a message for the user if it cannot listen there.
  CommandServer(const SocketAddress& address, CommandQueue& command_queue, TokenGuard& guard,
                const CommandLimits& limits = {});
  ~CommandServer();
  CommandServer(const CommandServer&) = delete;
  CommandServer& operator=(const CommandServer&) = delete;

  /// Where it listens, such as 127.0.0.1:8081.
  [[nodiscard]] std::string address() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace ilp::serve
