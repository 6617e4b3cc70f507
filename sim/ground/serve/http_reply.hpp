// Answers of the HTTP server, with the headers that all of them have.
#pragma once

#include <microhttpd.h>

#include <string>
#include <string_view>

#include "hal/posix/socket.hpp"

namespace ilp::serve {

/// The page takes nothing from elsewhere, and no other site may show it.
inline constexpr const char* page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What a client wrote, for a text that shows it again: its first 200 characters, those that are no ASCII as `?`.
[[nodiscard]] std::string shown(std::string_view text);

/// Copies the bytes.
[[nodiscard]] MHD_Response* response_of(std::string_view bytes);
/// Queues the response and gives it back to the library.
MHD_Result send(MHD_Connection* connection, unsigned status, MHD_Response* response, const char* type,
                const char* keep = "no-store");
/// A text that says why.
MHD_Result refuse(MHD_Connection* connection, unsigned status, const std::string& why);
/// 405, with the methods that are allowed, such as "GET, HEAD".
MHD_Result refuse_method(MHD_Connection* connection, const char* allowed, const std::string& why);
/// A part of the page by its name.
MHD_Result give_page_file(MHD_Connection* connection, std::string_view name);

[[nodiscard]] const char* content_type(std::string_view name);

/// The header "Host" is a name by which the server at `local` is served: localhost, 127.0.0.1, [::1] or the number
/// itself, with its port. A page of another site could otherwise reach it under a name that leads here (DNS rebinding).
[[nodiscard]] bool is_own_host(std::string_view host, const SocketAddress& local);
/// Answers a request with another Host (403).
MHD_Result refuse_host(MHD_Connection* connection, std::string_view host, const SocketAddress& local);
/// The value of a header; empty if there is none.
[[nodiscard]] std::string_view header(MHD_Connection* connection, const char* name);
[[nodiscard]] bool is_loopback(const SocketAddress& address);
/// 127.0.0.1:8080
[[nodiscard]] std::string address_text(const SocketAddress& address);

/// Listens at the address of --listen, which becomes the bound one. Throws std::runtime_error with a message for the
/// user.
[[nodiscard]] int listening_socket(SocketAddress& address);

}  // namespace ilp::serve
