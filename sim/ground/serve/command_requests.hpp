// Requests to the page's server that command the flight.
#pragma once

#include <string_view>

#include "sim/ground/serve/command_queue.hpp"
#include "sim/ground/serve/connection_places.hpp"
#include "sim/ground/serve/token_guard.hpp"

namespace ilp::serve {

/// What the server needs besides to take commands.
struct Commands {
  TokenGuard guard;
  CommandQueue queue;

  Commands(const std::string& token, console::OperatorSettings settings) : guard(token), queue(std::move(settings)) {}
};

constexpr std::size_t most_command_bytes = 2048;

/// These need the header "Authorization: Bearer TOKEN":
///   POST /commands      {"line":TEXT}: sends a telecommand; 200 with the line as it was understood, or a text that
///                       says why nothing was sent
///   /reports?after=     what CommandQueue::reports gives; waits at most 5 s
///   /help, /complete?typed=TEXT    lists of texts, as the console has them
/// There are no cookies, and a POST needs the header "Origin" with this server's own address, so that no page of
/// another site can send a command.
[[nodiscard]] bool is_command_path(std::string_view path);

/// By its headers, before anything of a body is read; none: it may be answered. The right token gives the connection
/// its standing in `places`.
[[nodiscard]] std::optional<MHD_Result> refuse_command(MHD_Connection* connection, bool post, Commands& commands,
                                                       ConnectionPlaces& places);
[[nodiscard]] MHD_Result answer_command(MHD_Connection* connection, std::string_view path, bool post,
                                        const std::string& body, Commands& commands);

}  // namespace ilp::serve
