// Exit status and exception for a mistake in a command line.
#pragma once

#include <stdexcept>

namespace ilp::host {

/// Exit status after a mistake in the command line. A program that could not do its work ends with 1.
inline constexpr int wrong_usage = 2;

/// Thrown for a mistake in the command line that its parser does not find. The program ends with `wrong_usage`.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ilp::host
