// How the programs of the board say what went wrong.
#pragma once

#include "bsp/flight/status_text.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Prints `what`, the text of the status with its values, and what to do, on standard error. `why`: further words about
/// it, or "".
void print_status(const char* what, const Status& status, const char* why = "");

}  // namespace ilp
