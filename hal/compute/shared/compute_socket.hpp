// The Unix socket between the flight and the program of a compute device. The flight connects and passes the descriptor
// of the shared memory.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// For the flight: connects `socket` to the program that listens at `path`, and passes it the descriptor `memory`. Does
/// not block. Returns `io_error` (first value: errno), or `invalid_argument` if the path is empty or too long.
Status connect_compute(const char* path, int memory, int& socket);

/// For the program: makes the socket `path` and listens. A file that has this path is replaced. Only the user of the
/// program may connect. Returns the same statuses as connect_compute().
Status listen_compute(const char* path, int& listener);
/// For the program: waits for a flight to connect. `memory` is the descriptor that the flight has passed. The caller
/// closes `socket` and `memory`. Returns `parse_error` if no descriptor arrives within a second or the client has gone,
/// `io_error` (first value: errno) if accepting fails.
Status accept_compute(int listener, int& socket, int& memory);

}  // namespace ilp
