// How the programs of the board say what went wrong.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

/// The text of the status with its values; the error of a system call is named.
[[nodiscard]] FixedText<512> status_sentence(const Status& status);

/// Prints `what`, the text of the status with its values, and what to do, on standard error. `why`: further words about
/// it, or "".
void print_status(const char* what, const Status& status, const char* why = "");

}  // namespace ilp
