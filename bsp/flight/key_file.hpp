// The keys of telecommand authentication, read at start-up.
#pragma once

#include "fsw/packets/authentication.hpp"

namespace ilp {

/// `not_found`, `io_error`, `file_not_private` if others may read it, `capacity_exceeded` for a file of more than 4 KiB
/// or with too many keys, `parse_error` (a = line).
Status read_key_file(const char* path, Authenticator& authenticator);

}  // namespace ilp
