// The Unix socket between the flight and the program of a compute device. The flight connects and passes its memory.
#pragma once

#include "fsw/base/status.hpp"

namespace ilp {

/// `socket` is connected to the program that listens at `path`, and `memory` has been passed to it. Does not block.
/// `io_error` (a = errno), `invalid_argument` (the path is too long).
Status connect_compute(const char* path, int memory, int& socket);

/// For the program: listens at `path`, in place of what a program before it has left there. Only its own user may
/// connect.
Status listen_compute(const char* path, int& listener);
/// Waits for a flight. `memory` is the file that it has passed; the caller closes both. `parse_error`: who connected
/// has passed none within a second, or has gone.
Status accept_compute(int listener, int& socket, int& memory);

}  // namespace ilp
