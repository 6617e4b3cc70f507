// Sends answers of the HTTP server with their common headers, and checks the header Host.
#pragma once

#include <microhttpd.h>

#include <string>
#include <string_view>

#include "hal/posix/socket.hpp"

namespace ilp::serve {

/// Content-Security-Policy of the page: it loads nothing from other sites, and no other site may embed it.
inline constexpr const char* page_policy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Text of a client for a message: its first 200 characters, with `?` for those that are not printable ASCII.
[[nodiscard]] std::string shown(std::string_view text);

/// A response with a copy of the bytes.
[[nodiscard]] MHD_Response* response_of(std::string_view bytes);
/// Queues the response and releases it. `type`: content type. `keep`: value of Cache-Control.
MHD_Result send(MHD_Connection* connection, unsigned status, MHD_Response* response, const char* type,
                const char* keep = "no-store");
/// Answers with an error status and a text.
MHD_Result refuse(MHD_Connection* connection, unsigned status, const std::string& why);
/// Answers 405 with the allowed methods, such as "GET, HEAD".
MHD_Result refuse_method(MHD_Connection* connection, const char* allowed, const std::string& why);
/// Answers with a file of the page (page_files.hpp).
MHD_Result give_page_file(MHD_Connection* connection, std::string_view name);

[[nodiscard]] const char* content_type(std::string_view name);

/// Whether the header "Host" names the server at `local`: localhost, 127.0.0.1, [::1] or the numeric address, with its
/// port. This prevents DNS rebinding, where a page of another site reaches the server under a foreign name.
[[nodiscard]] bool is_own_host(std::string_view host, const SocketAddress& local);
/// Answers a request with another Host by 403.
MHD_Result refuse_host(MHD_Connection* connection, std::string_view host, const SocketAddress& local);
/// The value of a header; empty if there is none.
[[nodiscard]] std::string_view header(MHD_Connection* connection, const char* name);
[[nodiscard]] bool is_loopback(const SocketAddress& address);
/// Text such as 127.0.0.1:8080.
[[nodiscard]] std::string address_text(const SocketAddress& address);

/// Opens a socket that listens at `address`, and sets `address` to the bound one (port 0: any free port). Throws
/// std::runtime_error with a message for the user, which names --listen.
[[nodiscard]] int listening_socket(SocketAddress& address);

}  // namespace ilp::serve
