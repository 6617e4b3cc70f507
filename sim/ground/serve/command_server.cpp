#include "sim/ground/serve/command_server.hpp"

#include <netinet/in.h>

#include <charconv>
#include <iostream>
#include <nlohmann/json.hpp>

#include "sim/ground/console/operator_command.hpp"
#include "sim/ground/serve/connection_places.hpp"
#include "sim/ground/serve/http_reply.hpp"

namespace ilp::serve {
namespace {

constexpr std::chrono::milliseconds longest_wait{5000};

bool is_command_part(std::string_view name) {
  return name == "commands.html" || name == "commands.js" || name.ends_with(".css");
}

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

// A request, from its headers to the end of its body.
struct PostedRequest {
  std::string body;
};

}  // namespace

struct CommandServer::Inside {
  CommandQueue& command_queue;
  TokenGuard& guard;
  CommandLimits limits;
  SocketAddress address;
  ConnectionPlaces places;
  MHD_Daemon* daemon = nullptr;

  Inside(CommandQueue& to, TokenGuard& by, const CommandLimits& bounds)
      : command_queue(to), guard(by), limits(bounds), places(limits.connections, limits.request, [] {}) {}

  std::optional<MHD_Result> refuse_by_headers(MHD_Connection* connection, const std::string& path,
                                              std::string_view method);
  std::optional<MHD_Result> refuse_without_token(MHD_Connection* connection);
  std::optional<MHD_Result> refuse_post(MHD_Connection* connection, const std::string& path);
  MHD_Result answer(MHD_Connection* connection, const std::string& path, std::string_view method,
                    const std::string& body);
  MHD_Result take_command(MHD_Connection* connection, const std::string& body);

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                               const char* version, const char* data, std::size_t* size, void** context);
  static void on_end(void* self, MHD_Connection* connection, void** context, MHD_RequestTerminationCode) {
    static_cast<Inside*>(self)->places.end_request(ConnectionPlaces::of(connection));
    delete static_cast<PostedRequest*>(*context);
    *context = nullptr;
  }
};

std::optional<MHD_Result> CommandServer::Inside::refuse_without_token(MHD_Connection* connection) {
  constexpr std::string_view scheme = "Bearer ";
  const std::string_view given = header(connection, "Authorization");
  if (!given.starts_with(scheme)) {
    return refuse(connection, MHD_HTTP_UNAUTHORIZED,
                  "the request has no token: it goes into the header Authorization, as Bearer TOKEN");
  }
  if (guard.is_right(given.substr(scheme.size()))) {
    places.trust(ConnectionPlaces::of(connection));
    return std::nullopt;
  }
  if (const auto wrong = guard.count_wrong(TokenGuard::Clock::now())) {
    const std::string line =
        "a wrong token came from " + client_of(connection) + "; " + std::to_string(*wrong) + " since the start";
    command_queue.say(line);
    std::cerr << "ilp-ground serve: " << line << std::endl;
  }
  return refuse(connection, MHD_HTTP_FORBIDDEN, "the token is wrong: it is the one that the server was started with");
}

std::optional<MHD_Result> CommandServer::Inside::refuse_post(MHD_Connection* connection, const std::string& path) {
  if (path != "/commands") return refuse_method(connection, "GET", "commands go to /commands");
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
  if (bytes > limits.body_bytes) {
    return refuse(connection, MHD_HTTP_CONTENT_TOO_LARGE,
                  "a command has at most " + std::to_string(limits.body_bytes) + " bytes");
  }
  return std::nullopt;
}

// Before anything of a body is read.
std::optional<MHD_Result> CommandServer::Inside::refuse_by_headers(MHD_Connection* connection, const std::string& path,
                                                                   std::string_view method) {
  const std::string_view host = header(connection, "Host");
  const SocketAddress& local = ConnectionPlaces::of(connection).local;
  if (!is_own_host(host, local)) return refuse_host(connection, host, local);
  const bool post = method == "POST";
  if (!post && method != "GET" && method != "HEAD") {
    return refuse_method(connection, "GET, HEAD, POST", "this server has no " + shown(method));
  }
  if (!post && (path == "/" || path.starts_with("/page/"))) return std::nullopt;
  if (const auto refused = refuse_without_token(connection)) return refused;
  return post ? refuse_post(connection, path) : std::nullopt;
}

MHD_Result CommandServer::Inside::take_command(MHD_Connection* connection, const std::string& body) {
  const nlohmann::json request = nlohmann::json::parse(body, nullptr, false);
  if (!request.is_object() || request.size() != 1 || !request.contains("line") || !request["line"].is_string()) {
    return refuse(connection, MHD_HTTP_BAD_REQUEST, R"(the body must be {"line":"capture +5"}, with one command)");
  }
  const auto line = request["line"].get<std::string>();
  for (const char c : line) {
    if (c < ' ' || c > '~') return refuse(connection, MHD_HTTP_BAD_REQUEST, "a command is one line of printable ASCII");
  }
  const CommandQueue::Answer answer = command_queue.enter(line);
  switch (answer.outcome) {
    case CommandQueue::Outcome::refused:
      return refuse(connection, MHD_HTTP_UNPROCESSABLE_CONTENT, "not sent: " + answer.text);
    case CommandQueue::Outcome::unavailable:
      return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE, "not sent: " + answer.text);
    default:
      return give_json(connection, {{"line", answer.text}});
  }
}

MHD_Result CommandServer::Inside::answer(MHD_Connection* connection, const std::string& path, std::string_view method,
                                         const std::string& body) {
  if (method == "POST") return take_command(connection, body);
  if (path == "/") return give_page_file(connection, "commands.html", is_command_part);
  if (path.starts_with("/page/")) return give_page_file(connection, std::string_view(path).substr(6), is_command_part);
  if (path == "/reports") {
    const std::string text = command_queue.reports(place_of(argument(connection, "after")), longest_wait);
    return send(connection, MHD_HTTP_OK, response_of(text), "application/json");
  }
  if (path == "/help") return give_json(connection, console::operator_help());
  if (path == "/complete") {
    return give_json(connection, console::complete_operator_line(argument(connection, "typed")));
  }
  return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no " + shown(path) + "; the page is /");
}

MHD_Result CommandServer::Inside::on_request(void* self, MHD_Connection* connection, const char* path,
                                             const char* method, const char*, const char* data, std::size_t* size,
                                             void** context) {
  Inside& server = *static_cast<Inside*>(self);
  try {
    if (*context == nullptr) {
      if (const auto refused = server.refuse_by_headers(connection, path, method)) {
        server.places.answer(ConnectionPlaces::of(connection));
        return *refused;
      }
      *context = new PostedRequest;
      return MHD_YES;
    }
    PostedRequest& request = *static_cast<PostedRequest*>(*context);
    if (*size > 0) {
      if (request.body.size() + *size > server.limits.body_bytes) return MHD_NO;
      request.body.append(data, *size);
      *size = 0;
      return MHD_YES;
    }
    server.places.answer(ConnectionPlaces::of(connection));
    return server.answer(connection, path, method, request.body);
  } catch (const std::exception&) {
    // No memory left for this client: its connection is closed.
    return MHD_NO;
  }
}

CommandServer::CommandServer(const SocketAddress& address, CommandQueue& command_queue, TokenGuard& guard,
                             const CommandLimits& limits)
    : inside_(std::make_unique<Inside>(command_queue, guard, limits)) {
  inside_->address = address;
  inside_->daemon =
      start_daemon(inside_->address, "--commands",
                   {&Inside::on_request, &Inside::on_end, inside_.get(), limits.bytes_per_connection, limits.idle_s},
                   inside_->places);
}

CommandServer::~CommandServer() {
  inside_->command_queue.end();
  MHD_stop_daemon(inside_->daemon);
}

std::string CommandServer::address() const {
  return address_text(inside_->address);
}

}  // namespace ilp::serve
