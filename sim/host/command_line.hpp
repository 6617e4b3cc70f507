// Reads the command line of host programs, with the same --help, error messages and exit statuses in all of them.
// bsp/packages/man-page makes the manual pages from --help.
#pragma once

#include <CLI/CLI.hpp>
#include <iosfwd>
#include <optional>
#include <string>

#include "sim/host/wrong_usage.hpp"

namespace ilp::host {

inline constexpr const char* exit_statuses = "Exit status: 0 done, 1 the work could not be done, 2 wrong call";

/// A program, or a subcommand that reads its own command line. --help says what the program does, and lists its options
/// with defaults, an example and the exit statuses.
class CommandLine : public CLI::App {
 public:
  CommandLine(const std::string& name, const std::string& what, const std::string& example,
              const std::string& statuses = exit_statuses);
};

/// Adds a subcommand whose options are read with those of its program. It has the same --help.
CLI::App& add_subcommand(CLI::App& app, const std::string& name, const std::string& what, const std::string& example,
                         const std::string& statuses = exit_statuses);

/// Reads the command line; refuses fractions for integer options and numbers that are not finite. Empty if the program
/// shall go on. Otherwise the reason is written to `out` or `err`, and the result is the exit status: 0 after --help
/// and --version, else `wrong_usage`.
std::optional<int> read_command_line(CLI::App& app, int argc, char** argv, std::ostream& out, std::ostream& err);
std::optional<int> read_command_line(CLI::App& app, int argc, char** argv);

}  // namespace ilp::host
