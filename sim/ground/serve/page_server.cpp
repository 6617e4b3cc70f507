#include "sim/ground/serve/page_server.hpp"

#include <arpa/inet.h>
#include <microhttpd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <stdexcept>

#include "hal/posix/socket_address.hpp"
#include "sim/ground/serve/page_files.hpp"

namespace ilp::serve {
namespace {

constexpr std::uint32_t first_loopback = 0x7F000000, loopback_mask = 0xFF000000;
constexpr std::chrono::milliseconds alive_every{5000};
constexpr std::size_t stream_block = 32768;

// The page takes nothing from elsewhere, and no other site may show it.
constexpr const char* page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; frame-src "
    "'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const char* content_type(std::string_view name) {
  static constexpr std::pair<std::string_view, const char*> types[] = {{".html", "text/html; charset=utf-8"},
                                                                       {".css", "text/css; charset=utf-8"},
                                                                       {".js", "text/javascript; charset=utf-8"},
                                                                       {".json", "application/json"},
                                                                       {".geojson", "application/geo+json"},
                                                                       {".png", "image/png"},
                                                                       {".csv", "text/csv; charset=utf-8"},
                                                                       {".tif", "image/tiff"},
                                                                       {".glb", "model/gltf-binary"},
                                                                       {".txt", "text/plain; charset=utf-8"}};
  for (const auto& [ending, type] : types) {
    if (name.ends_with(ending)) return type;
  }
  return "application/octet-stream";
}

// What a client wrote, for a text that shows it again.
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 200)) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

void add_header(MHD_Response* response, const char* name, const char* value) {
  (void)MHD_add_response_header(response, name, value);
}

MHD_Result send(MHD_Connection* connection, unsigned status, MHD_Response* response, const char* type,
                const char* keep = "no-store") {
  if (response == nullptr) return MHD_NO;
  add_header(response, "Content-Type", type);
  add_header(response, "Cache-Control", keep);
  add_header(response, "X-Content-Type-Options", "nosniff");
  add_header(response, "Referrer-Policy", "no-referrer");
  add_header(response, "Cross-Origin-Resource-Policy", "same-origin");
  if (status == MHD_HTTP_METHOD_NOT_ALLOWED) add_header(response, "Allow", "GET, HEAD");
  const MHD_Result result = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);
  return result;
}

MHD_Response* response_of(std::string_view bytes) {
  return MHD_create_response_from_buffer(bytes.size(), const_cast<char*>(bytes.data()), MHD_RESPMEM_MUST_COPY);
}

MHD_Result refuse(MHD_Connection* connection, unsigned status, const std::string& why) {
  return send(connection, status, response_of(std::to_string(status) + ": " + why + "\n"), "text/plain; charset=utf-8");
}

// A page of another site could otherwise read the flight under a name that leads here (DNS rebinding).
bool names_this_computer(std::string_view host) {
  if (host.starts_with("[")) return host.starts_with("[::1]");
  const std::string name(host.substr(0, host.find(':')));
  in_addr number{};
  return name == "localhost" || ::inet_pton(AF_INET, name.c_str(), &number) == 1;
}

std::string address_text(const SocketAddress& address) {
  in_addr number{};
  number.s_addr = htonl(address.host);
  char text[INET_ADDRSTRLEN] = {};
  (void)::inet_ntop(AF_INET, &number, text, sizeof(text));
  return std::string(text) + ":" + std::to_string(address.port);
}

std::string advice_for(int error) {
  switch (error) {
    case EADDRINUSE:
      return "; another program uses this port: end that program, or name another port with --listen (port 0: any free "
             "one)";
    case EADDRNOTAVAIL:
      return "; name an address of this computer (ip address lists them)";
    case EACCES:
      return "; name a port from 1024 on";
    default:
      return "";
  }
}

}  // namespace

struct PageServer::Inside {
  // A page that listens.
  struct Stream {
    Inside& server;
    std::optional<Place> place;
    std::string pending;  ///< of which `sent` bytes are sent
    std::size_t sent = 0;
    bool begun = false;

    explicit Stream(Inside& inside) : server(inside) {}
    ~Stream() { --server.streams; }
    void refill();
  };

  LiveFlight& flight;
  ServerLimits limits;
  SocketAddress address;
  MHD_Daemon* daemon = nullptr;
  std::atomic<unsigned> streams = 0;
  std::atomic<bool> ending = false;

  Inside(LiveFlight& of, const ServerLimits& bounds) : flight(of), limits(bounds) {}

  MHD_Result answer(MHD_Connection* connection, const std::string& path, std::string_view method);
  MHD_Result give_page_file(MHD_Connection* connection, std::string_view name) const;
  MHD_Result give_picture(MHD_Connection* connection, const std::string& path) const;
  MHD_Result give_file(MHD_Connection* connection, const std::string& name) const;
  MHD_Result give_events(MHD_Connection* connection);

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                               const char* version, const char* data, std::size_t* size, void** context);
  static ssize_t read_stream(void* stream, std::uint64_t at, char* buffer, std::size_t most);
};

void PageServer::Inside::Stream::refill() {
  sent = 0;
  pending.clear();
  // The first answer comes at once, so that a page knows that it is connected.
  if (!begun) pending = "retry: 2000\n\n";
  const bool news = begun && place ? server.flight.state().wait(*place, alive_every) : true;
  if (server.ending) return;
  if (news) {
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
  if (++streams > limits.streams) {
    --streams;
    return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE,
                  std::to_string(limits.streams) + " pages listen already: close one of them");
  }
  auto stream = std::make_unique<Stream>(*this);
  const char* last = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Last-Event-ID");
  if (last != nullptr) stream->place = place_of(last);
  MHD_Response* response = MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, stream_block, &read_stream, stream.get(),
                                                             [](void* ended) { delete static_cast<Stream*>(ended); });
  if (response != nullptr) (void)stream.release();
  return send(connection, MHD_HTTP_OK, response, "text/event-stream; charset=utf-8");
}

MHD_Result PageServer::Inside::give_page_file(MHD_Connection* connection, std::string_view name) const {
  for (const PageFile& file : page_files()) {
    if (file.name != name) continue;
    MHD_Response* response = response_of(file.text);
    if (response != nullptr) add_header(response, "Content-Security-Policy", page_policy);
    return send(connection, MHD_HTTP_OK, response, content_type(name));
  }
  return refuse(connection, MHD_HTTP_NOT_FOUND, "the page has no part /page/" + shown(name));
}

MHD_Result PageServer::Inside::give_picture(MHD_Connection* connection, const std::string& path) const {
  const auto picture = flight.shelf().picture(path);
  if (!picture)
    return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no picture " + shown(path) + " any more; load / again");
  const std::string_view bytes(reinterpret_cast<const char*>(picture->data()), picture->size());
  return send(connection, MHD_HTTP_OK, response_of(bytes), "image/png", "private, max-age=86400, immutable");
}

MHD_Result PageServer::Inside::give_file(MHD_Connection* connection, const std::string& name) const {
  const OpenFile file = flight.shelf().open(name);
  if (!file.known) {
    return refuse(connection, MHD_HTTP_NOT_FOUND,
                  "the results have no file " + shown(name) + "; / lists those that they have");
  }
  if (file.file < 0) {
    return refuse(connection, MHD_HTTP_SERVICE_UNAVAILABLE,
                  shown(name) + " is being written, or is no plain file; try again in a moment");
  }
  // The response closes the file.
  return send(connection, MHD_HTTP_OK, MHD_create_response_from_fd64(file.bytes, file.file), content_type(name),
              "no-cache");
}

MHD_Result PageServer::Inside::answer(MHD_Connection* connection, const std::string& path, std::string_view method) {
  if (method != "GET" && method != "HEAD") {
    return refuse(connection, MHD_HTTP_METHOD_NOT_ALLOWED,
                  "this server only shows a flight: it answers GET and HEAD, not " + shown(method));
  }
  const char* host = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host");
  if ((address.host & loopback_mask) == first_loopback && host != nullptr && !names_this_computer(host)) {
    return refuse(connection, MHD_HTTP_FORBIDDEN,
                  "the host " + shown(host) + " is not this computer; open http://" +
                      "localhost:" + std::to_string(address.port));
  }
  if (path == "/") return give_page_file(connection, "index.html");
  if (path.starts_with("/page/")) return give_page_file(connection, std::string_view(path).substr(6));
  if (path.starts_with("/map/")) return give_picture(connection, path);
  if (path.starts_with("/files/")) return give_file(connection, path.substr(7));
  if (path == "/state")
    return send(connection, MHD_HTTP_OK, response_of(flight.state().since({}).json), "application/json");
  if (path == "/events") return give_events(connection);
  return refuse(connection, MHD_HTTP_NOT_FOUND, "there is no " + shown(path) + "; the page is /");
}

MHD_Result PageServer::Inside::on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                                          const char*, const char*, std::size_t* size, void** context) {
  Inside& server = *static_cast<Inside*>(self);
  // An answer in the second call keeps the connection open; a request with a body is answered at once, and ends it.
  const bool bodiless = std::string_view(method) == "GET" || std::string_view(method) == "HEAD";
  if (*context == nullptr && bodiless) {
    *context = self;
    return MHD_YES;
  }
  if (*size > 0) return MHD_NO;
  try {
    return server.answer(connection, path, method);
  } catch (const std::exception&) {
    // No memory left for this client: its connection is closed.
    return MHD_NO;
  }
}

PageServer::PageServer(const SocketAddress& address, LiveFlight& flight, const ServerLimits& limits)
    : inside_(std::make_unique<Inside>(flight, limits)) {
  int socket = -1;
  const std::string wanted = address_text(address);
  const Status opened = open_socket(SocketKind::tcp, address, socket);
  if (!opened.ok()) {
    throw std::runtime_error("cannot listen at " + wanted + ": " + std::strerror(static_cast<int>(opened.a)) +
                             advice_for(static_cast<int>(opened.a)));
  }
  (void)local_address(socket, inside_->address);
  // The server closes the socket.
  inside_->daemon =
      MHD_start_daemon(MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_THREAD_PER_CONNECTION | MHD_USE_POLL, 0, nullptr,
                       nullptr, &Inside::on_request, inside_.get(), MHD_OPTION_LISTEN_SOCKET, socket,
                       MHD_OPTION_CONNECTION_LIMIT, limits.connections, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
                       limits.bytes_per_connection, MHD_OPTION_CONNECTION_TIMEOUT, limits.idle_s, MHD_OPTION_END);
  if (inside_->daemon == nullptr) {
    close_socket(socket);
    throw std::runtime_error("cannot serve at " + wanted + ": no thread can be started; end other programs");
  }
}

PageServer::~PageServer() {
  inside_->ending = true;
  inside_->flight.state().end();
  MHD_stop_daemon(inside_->daemon);
}

std::string PageServer::address() const {
  return address_text(inside_->address);
}

}  // namespace ilp::serve
