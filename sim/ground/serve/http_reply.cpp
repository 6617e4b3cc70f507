#include "sim/ground/serve/http_reply.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "sim/ground/serve/page_files.hpp"

namespace ilp::serve {
namespace {

void add_header(MHD_Response* response, const char* name, const char* value) {
  (void)MHD_add_response_header(response, name, value);
}

const char* advice_for(int error) {
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

std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 200)) out += c >= ' ' && c <= '~' ? c : '?';
  return out;
}

MHD_Result send(MHD_Connection* connection, unsigned status, MHD_Response* response, const char* type,
                const char* keep) {
  if (response == nullptr) return MHD_NO;
  add_header(response, "Content-Type", type);
  add_header(response, "Cache-Control", keep);
  add_header(response, "X-Content-Type-Options", "nosniff");
  add_header(response, "Referrer-Policy", "no-referrer");
  add_header(response, "Cross-Origin-Resource-Policy", "same-origin");
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

MHD_Result refuse_method(MHD_Connection* connection, const char* allowed, const std::string& why) {
  MHD_Response* response = response_of("405: " + why + "\n");
  if (response != nullptr) add_header(response, "Allow", allowed);
  return send(connection, MHD_HTTP_METHOD_NOT_ALLOWED, response, "text/plain; charset=utf-8");
}

MHD_Result give_page_file(MHD_Connection* connection, std::string_view name) {
  for (const PageFile& file : page_files()) {
    if (file.name != name) continue;
    MHD_Response* response = response_of(file.text);
    if (response != nullptr) add_header(response, "Content-Security-Policy", page_policy);
    return send(connection, MHD_HTTP_OK, response, content_type(name));
  }
  return refuse(connection, MHD_HTTP_NOT_FOUND, "the page has no part /page/" + shown(name));
}

bool is_loopback(const SocketAddress& address) {
  constexpr std::uint32_t first = 0x7F000000, mask = 0xFF000000;
  return (address.host & mask) == first;
}

bool is_own_host(std::string_view host, const SocketAddress& local) {
  const std::string own = address_text(local), port = own.substr(own.find(':'));
  if (local.port == 80 && !host.ends_with(port)) return is_own_host(std::string(host) + port, local);
  return host == own || host == "localhost" + port || host == "127.0.0.1" + port || host == "[::1]" + port;
}

MHD_Result refuse_host(MHD_Connection* connection, std::string_view host, const SocketAddress& local) {
  const std::string own = address_text(local), port = own.substr(own.find(':'));
  return refuse(connection, MHD_HTTP_FORBIDDEN,
                "this server is not " + (host.empty() ? "without a name" : shown(host)) + ": open http://" + own +
                    (is_loopback(local) ? " or http://localhost" + port + "; a tunnel keeps the port" : ""));
}

std::string_view header(MHD_Connection* connection, const char* name) {
  const char* value = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, name);
  return value == nullptr ? std::string_view() : value;
}

std::string address_text(const SocketAddress& address) {
  in_addr number{};
  number.s_addr = htonl(address.host);
  char text[INET_ADDRSTRLEN] = {};
  (void)::inet_ntop(AF_INET, &number, text, sizeof(text));
  return std::string(text) + ":" + std::to_string(address.port);
}

int listening_socket(SocketAddress& address) {
  int socket = -1;
  const std::string wanted = address_text(address);
  const Status opened = open_socket(SocketKind::tcp, address, socket);
  if (!opened.ok()) {
    throw std::runtime_error("cannot listen at " + wanted + ": " + std::strerror(static_cast<int>(opened.a)) +
                             advice_for(static_cast<int>(opened.a)));
  }
  (void)local_address(socket, address);
  return socket;
}

}  // namespace ilp::serve
