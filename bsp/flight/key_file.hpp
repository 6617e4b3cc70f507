// The keys of telecommand authentication, read at start-up.
#pragma once

#include "fsw/packets/authentication.hpp"

namespace ilp {

/// `not_found`, `io_error`, `capacity_exceeded` for a file of more than 4 KiB or with too many keys, `parse_error` (a =
/// line).
Status read_key_file(const char* path, Authenticator& authenticator);

}  // namespace ilp
