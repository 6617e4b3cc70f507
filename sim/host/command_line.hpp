// How host programs read their command line, so that all end with the same status.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace ilp::host {

/// Status of a program that was not called as it has to be. A program that could not do its work ends with 1.
inline constexpr int wrong_usage = 2;

/// Reads the command line. If the program shall end now, it has printed why, and this is its status.
inline std::optional<int> read_command_line(CLI::App& app, int argc, char** argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : wrong_usage;
  }
  return std::nullopt;
}

}  // namespace ilp::host
