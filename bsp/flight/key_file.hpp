// Reads the keys of telecommand authentication from a file at start-up.
#pragma once

#include "fsw/packets/authentication.hpp"

namespace ilp {

/// Reads the keys into `authenticator`. Returns `not_found`, `io_error` or `file_not_private` as read_private_file(),
/// `capacity_exceeded` if the file has more than 4 KiB or too many keys, and `parse_error` (first value: line) for a
/// malformed line.
Status read_key_file(const char* path, Authenticator& authenticator);

}  // namespace ilp
