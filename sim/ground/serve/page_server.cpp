#include "sim/ground/serve/page_server.hpp"

#include <atomic>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "sim/ground/serve/http_reply.hpp"

namespace ilp::serve {
namespace {

constexpr std::chrono::milliseconds alive_every{5000};
constexpr std::size_t stream_block = 32768;
// A page of its own that cannot act for this one, whatever a file says: it has no origin.
constexpr const char* file_policy = "sandbox allow-scripts allow-downloads allow-popups";

}  // namespace

struct PageServer::Inside {
  // A page that listens.
  struct Stream {
    Inside& server;
    const ConnectionPlaces::Connection& connection;
    std::optional<Place> place;
    std::string pending;  ///< of which `sent` bytes are sent
    std::size_t sent = 0;
    bool begun = false;

    Stream(Inside& inside, const ConnectionPlaces::Connection& at) : server(inside), connection(at) {}
    void refill();
  };

  LiveFlight& flight;
  Commands* commands;  ///< may be null
  ServerLimits limits;
  SocketAddress address;
  ConnectionPlaces places;
  MHD_Daemon* daemon = nullptr;
  std::atomic<bool> ending = false;

  Inside(LiveFlight& of, Commands* by, const ServerLimits& bounds)
      : flight(of),
        commands(by),
        limits(bounds),
        places(limits.connections, limits.request, [this] { flight.state().wake(); }) {}

  [[nodiscard]] bool is_commanding(std::string_view path) const { return commands != nullptr && is_command_path(path); }
  std::optional<MHD_Result> refuse_by_headers(MHD_Connection* connection, const std::string& path,
                                              std::string_view method);
  MHD_Result answer(MHD_Connection* connection, const std::string& path, bool post, const std::string& body);
  MHD_Result give_picture(MHD_Connection* connection, const std::string& path) const;
  MHD_Result give_file(MHD_Connection* connection, const std::string& name) const;
  MHD_Result give_events(MHD_Connection* connection);

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                               const char* version, const char* data, std::size_t* size, void** context);
  static void on_end(void* self, MHD_Connection* connection, void** context, MHD_RequestTerminationCode code);
  static ssize_t read_stream(void* stream, std::uint64_t at, char* buffer, std::size_t most);
};

void PageServer::Inside::Stream::refill() {
  sent = 0;
  pending.clear();
  // The first answer comes at once, so that a page knows that it is connected.
  if (!begun) pending = "retry: 2000\n\n";
  const bool updates = begun && place ? server.flight.state().wait(*place, alive_every, connection.gone) : true;
  if (server.ending || connection.gone) return;
  if (updates) {
    const Update update = server.flight.state().since(place);
    place = update.place;
    pending += "id: " + text_of(update.place) + "\ndata: " + update.json + "\n\n";
  } else {
    pending += "event: alive\ndata:\n\n";
  }
  begun = true;
}

ssize_t PageServer::Inside::read_stream(void* stream, std::uint64_t, char* buffer, std::size_t most) {
  Stream& self = *static_cast<Stream*>(stream);
  if (self.sent == self.pending.size()) self.refill();
  if (self.pending.empty()) return MHD_CONTENT_READER_END_OF_STREAM;
  const std::size_t bytes = std::min(most, self.pending.size() - self.sent);
  std::memcpy(buffer, self.pending.data() + self.sent, bytes);
  self.sent += bytes;
  return static_cast<ssize_t>(bytes);
}

MHD_Result PageServer::Inside::give_events(MHD_Connection* connection) {
  auto stream = std::make_unique<Stream>(*this, ConnectionPlaces::of(connection));
  stream->place = place_of(header(connection, "Last-Event-ID"));
  MHD_Response* response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, stream_block, &read_stream, stream.get(),
                                                             [](void* ended) { delete static_cast<Stream*>(ended); });
  if (response != nullptr) (void)stream.release();
  return send(connection, MHD_HTTP_OK, response, "text/event-stream; charset=utf-8");
}

MHD_Result PageServer::Inside::give_picture(MHD_Connection* connection, const std::string& path) const {
  const auto picture = flight.static_files().picture(path);
  if (!picture)
    return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no picture " + shown(path) + " any more; load / again");
  const std::string_view bytes(reinterpret_cast<const char*>(picture->data()), picture->size());
  return send(connection, MHD_HTTP_OK, response_of(bytes), "image/png", "private, max-age=86400, immutable");
}

MHD_Result PageServer::Inside::give_file(MHD_Connection* connection, const std::string& name) const {
  const OpenFile file = flight.static_files().open(name);
  if (!file.known) {
    return refuse(connection, MHD_HTTP_NOT_FOUND,
                  "the results have no file " + shown(name) + "; / lists those that they have");
  }
  if (file.file < 0) {
    return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE,
                  shown(name) + " is being written, or is no plain file; try again in a moment");
  }
  // The response closes the file.
  MHD_Response* response = MHD_create_response_from_fd64(file.bytes, file.file);
  if (response != nullptr) (void)MHD_add_response_header(response, "Content-Security-Policy", file_policy);
  return send(connection, MHD_HTTP_OK, response, content_type(name), "no-cache");
}

// Before anything of a body is read.
std::optional<MHD_Result> PageServer::Inside::refuse_by_headers(MHD_Connection* connection, const std::string& path,
                                                                std::string_view method) {
  const std::string_view host = header(connection, "Host");
  const SocketAddress& local = ConnectionPlaces::of(connection).local;
  if (!is_own_host(host, local)) return refuse_host(connection, host, local);
  const bool takes_post = commands != nullptr && path == "/commands", post = takes_post && method == "POST";
  if (!post && method != "GET" && method != "HEAD") {
    return refuse_method(connection, takes_post ? "GET, HEAD, POST" : "GET, HEAD",
                         shown(path) + " is for GET and HEAD, not for " + shown(method));
  }
  return is_commanding(path) ? refuse_command(connection, post, *commands, places) : std::nullopt;
}

MHD_Result PageServer::Inside::answer(MHD_Connection* connection, const std::string& path, bool post,
                                      const std::string& body) {
  if (is_commanding(path)) return answer_command(connection, path, post, body, *commands);
  if (path == "/") return give_page_file(connection, "index.html");
  const bool page = path.starts_with("/page/") && (commands != nullptr || path != "/page/commands.js");
  if (page) return give_page_file(connection, std::string_view(path).substr(6));
  if (path.starts_with("/map/")) return give_picture(connection, path);
  if (path.starts_with("/files/")) return give_file(connection, path.substr(7));
  if (path == "/state")
    return send(connection, MHD_HTTP_OK, response_of(flight.state().since({}).json), "application/json");
  if (path == "/events") return give_events(connection);
  return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no " + shown(path) + "; the page is /");
}

MHD_Result PageServer::Inside::on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                                          const char*, const char* data, std::size_t* size, void** context) {
  Inside& server = *static_cast<Inside*>(self);
  try {
    if (*context == nullptr) {
      const auto refused = server.refuse_by_headers(connection, path, method);
      if (refused) {
        server.places.answer(ConnectionPlaces::of(connection));
        return *refused;
      }
      *context = new std::string;
      return MHD_YES;
    }
    std::string& body = *static_cast<std::string*>(*context);
    if (*size > 0) {
      if (body.size() + *size > most_command_bytes) return MHD_NO;
      body.append(data, *size);
      *size = 0;
      return MHD_YES;
    }
    server.places.answer(ConnectionPlaces::of(connection));
    return server.answer(connection, path, std::string_view(method) == "POST", body);
  } catch (const std::exception&) {
    // No memory left for this client: its connection is closed.
    return MHD_NO;
  }
}

void PageServer::Inside::on_end(void* self, MHD_Connection* connection, void** context, MHD_RequestTerminationCode) {
  static_cast<Inside*>(self)->places.end_request(ConnectionPlaces::of(connection));
  delete static_cast<std::string*>(*context);
  *context = nullptr;
}

PageServer::PageServer(const SocketAddress& address, LiveFlight& flight, Commands* commands, const ServerLimits& limits)
    : inside_(std::make_unique<Inside>(flight, commands, limits)) {
  Inside& server = *inside_;
  server.address = address;
  int socket = listening_socket(server.address);
  // The library closes the socket.
  server.daemon = MHD_start_daemon(
      MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL, 0, nullptr, nullptr,
      &Inside::on_request, &server, MHD_OPTION_LISTEN_SOCKET, socket, MHD_OPTION_CONNECTION_LIMIT,
      server.places.library_limit(), MHD_OPTION_CONNECTION_MEMORY_LIMIT, limits.bytes_per_connection,
      MHD_OPTION_CONNECTION_TIMEOUT, limits.idle_s, MHD_OPTION_NOTIFY_CONNECTION, &ConnectionPlaces::on_connection,
      &server.places, MHD_OPTION_NOTIFY_COMPLETED, &Inside::on_end, &server, MHD_OPTION_END);
  if (server.daemon != nullptr) return;
  close_socket(socket);
  throw std::runtime_error("cannot serve at " + address_text(server.address) +
                           ": no thread can be started; end other programs");
}

PageServer::~PageServer() {
  inside_->ending = true;
  inside_->flight.state().end();
  if (inside_->commands != nullptr) inside_->commands->queue.end();
  MHD_stop_daemon(inside_->daemon);
}

std::string PageServer::address() const {
  return address_text(inside_->address);
}

}  // namespace ilp::serve
