#include "sim/ground/serve/command_requests.hpp"

#include <netinet/in.h>

#include <charconv>
#include <iostream>
#include <nlohmann/json.hpp>

#include "sim/ground/console/operator_command.hpp"
#include "sim/ground/serve/http_reply.hpp"

namespace ilp::serve {
namespace {

constexpr std::chrono::milliseconds longest_wait{5000};

std::string argument(MHD_Connection* connection, const char* name) {
  const char* value = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, name);
  return value == nullptr ? "" : value;
}

std::string client_of(MHD_Connection* connection) {
  const MHD_ConnectionInfo* info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  if (info == nullptr || info->client_addr == nullptr || info->client_addr->sa_family != AF_INET) return "?";
  const std::string text =
      address_text({ntohl(reinterpret_cast<const sockaddr_in*>(info->client_addr)->sin_addr.s_addr), 0});
  return text.substr(0, text.find(':'));
}

MHD_Result give_json(MHD_Connection* connection, const nlohmann::json& value) {
  const std::string text = value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return send(connection, MHD_HTTP_OK, response_of(text), "application/json");
}

std::optional<MHD_Result> refuse_without_token(MHD_Connection* connection, Commands& commands,
                                               ConnectionPlaces& places) {
  constexpr std::string_view scheme = "Bearer ";
  const std::string_view given = header(connection, "Authorization");
  if (!given.starts_with(scheme)) {
    return refuse(connection, MHD_HTTP_UNAUTHORIZED,
                  "the request has no token: it goes into the header Authorization, as Bearer TOKEN");
  }
  if (commands.guard.is_right(given.substr(scheme.size()))) {
    places.trust(ConnectionPlaces::of(connection));
    return std::nullopt;
  }
  if (const auto wrong = commands.guard.count_wrong(TokenGuard::Clock::now())) {
    const std::string line =
        "a wrong token came from " + client_of(connection) + "; " + std::to_string(*wrong) + " since the start";
    commands.queue.say(line);
    std::cerr << "ilp-ground serve: " << line << std::endl;
  }
  return refuse(connection, MHD_HTTP_FORBIDDEN, "the token is wrong: it is the one that the server was started with");
}

std::optional<MHD_Result> refuse_post(MHD_Connection* connection) {
  const std::string own = "http://" + std::string(header(connection, "Host"));
  const std::string_view origin = header(connection, "Origin");
  if (origin != own) {
    return refuse(connection, MHD_HTTP_FORBIDDEN,
                  "commands come from this server's own page: the header Origin must be " + shown(own) + ", not " +
                      (origin.empty() ? "absent" : shown(origin)));
  }
  if (header(connection, "Content-Type") != "application/json") {
    return refuse(connection, MHD_HTTP_UNSUPPORTED_MEDIA_TYPE, "the Content-Type must be application/json");
  }
  const std::string_view length = header(connection, "Content-Length");
  std::size_t bytes = 0;
  const auto end = std::from_chars(length.data(), length.data() + length.size(), bytes);
  if (length.empty() || end.ec != std::errc() || end.ptr != length.data() + length.size()) {
    return refuse(connection, MHD_HTTP_LENGTH_REQUIRED, "the header Content-Length must say how long the body is");
  }
  if (bytes > most_command_bytes) {
    return refuse(connection, MHD_HTTP_CONTENT_TOO_LARGE,
                  "a command has at most " + std::to_string(most_command_bytes) + " bytes");
  }
  return std::nullopt;
}

MHD_Result take_command(MHD_Connection* connection, const std::string& body, CommandQueue& queue) {
  const nlohmann::json request = nlohmann::json::parse(body, nullptr, false);
  if (!request.is_object() || request.size() != 1 || !request.contains("line") || !request["line"].is_string()) {
    return refuse(connection, MHD_HTTP_BAD_REQUEST, R"(the body must be {"line":"capture +5"}, with one command)");
  }
  const auto line = request["line"].get<std::string>();
  for (const char c : line) {
    if (c < ' ' || c > '~') return refuse(connection, MHD_HTTP_BAD_REQUEST, "a command is one line of printable ASCII");
  }
  const CommandQueue::Answer answer = queue.enter(line);
  switch (answer.outcome) {
    case CommandQueue::Outcome::refused:
      return refuse(connection, MHD_HTTP_UNPROCESSABLE_CONTENT, "not sent: " + answer.text);
    case CommandQueue::Outcome::unavailable:
      return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "not sent: " + answer.text);
    default:
      return give_json(connection, {{"line", answer.text}});
  }
}

}  // namespace

bool is_command_path(std::string_view path) {
  return path == "/commands" || path == "/reports" || path == "/help" || path == "/complete";
}

std::optional<MHD_Result> refuse_command(MHD_Connection* connection, bool post, Commands& commands,
                                         ConnectionPlaces& places) {
  if (const auto refused = refuse_without_token(connection, commands, places)) return refused;
  return post ? refuse_post(connection) : std::nullopt;
}

MHD_Result answer_command(MHD_Connection* connection, std::string_view path, bool post, const std::string& body,
                          Commands& commands) {
  if (post) return take_command(connection, body, commands.queue);
  if (path == "/reports") {
    const std::string text = commands.queue.reports(place_of(argument(connection, "after")), longest_wait);
    return send(connection, MHD_HTTP_OK, response_of(text), "application/json");
  }
  if (path == "/help") return give_json(connection, console::operator_help());
  if (path == "/complete") {
    return give_json(connection, console::complete_operator_line(argument(connection, "typed")));
  }
  return refuse_method(connection, "POST", shown(path) + " takes commands by POST");
}

}  // namespace ilp::serve
