// A mistake in the command line of a program.
#pragma once

#include <stdexcept>

namespace ilp::host {

/// Status of a program that was not called as it has to be. A program that could not do its work ends with 1.
inline constexpr int wrong_usage = 2;

/// A mistake that the reader of the command line cannot see: the program ends with `wrong_usage`.
struct WrongUsage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace ilp::host
