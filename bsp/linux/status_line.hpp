// Prints a Status as a message of a program of the board.
#pragma once

#include "bsp/flight/status_text.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Prints on standard error: `what`, the text of the status with its values, `why` if it is not empty, and what to do.
void print_status(const char* what, const Status& status, const char* why = "");

}  // namespace ilp
