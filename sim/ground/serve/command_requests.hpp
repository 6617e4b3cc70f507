// Answers the requests to the page's server that command the flight.
#pragma once

#include <string_view>

#include "sim/ground/serve/command_queue.hpp"
#include "sim/ground/serve/connection_places.hpp"
#include "sim/ground/serve/token_guard.hpp"

namespace ilp::serve {

/// What the server needs in addition for commands.
struct Commands {
  TokenGuard guard;
  CommandQueue queue;

  Commands(const std::string& token, console::OperatorSettings settings) : guard(token), queue(std::move(settings)) {}
};

constexpr std::size_t most_command_bytes = 2048;

/// Whether a path is one of these. They need the header "Authorization: Bearer TOKEN":
///   POST /commands      {"line":TEXT}: sends a telecommand; 200 with the command as parsed, or another status with a
///                       text that says why it was not sent
///   /reports?after=     JSON of CommandQueue::reports; waits at most 5 s
///   /help, /complete?typed=TEXT    lists of texts, as in the console
/// There are no cookies, and a POST needs the header "Origin" with this server's own address, so that a page of another
/// site cannot send a command.
[[nodiscard]] bool is_command_path(std::string_view path);

/// Checks the headers of a request before its body is read, and refuses it if necessary; none: it may be answered. The
/// right token makes the connection trusted in `places`.
[[nodiscard]] std::optional<MHD_Result> refuse_command(MHD_Connection* connection, bool post, Commands& commands,
                                                       ConnectionPlaces& places);
[[nodiscard]] MHD_Result answer_command(MHD_Connection* connection, std::string_view path, bool post,
                                        const std::string& body, Commands& commands);

}  // namespace ilp::serve
