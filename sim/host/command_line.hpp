// How host programs read their command line, so that all answer --help, name mistaken words and end with the same
// status. bsp/packages/man-page makes the manual pages from --help.
#pragma once

#include <CLI/CLI.hpp>
#include <iosfwd>
#include <optional>
#include <string>

#include "sim/host/wrong_usage.hpp"

namespace ilp::host {

inline constexpr const char* exit_statuses = "Exit status: 0 done, 1 the work could not be done, 2 wrong call";

/// A program, or a subcommand that reads its own command line. --help tells what it does, the values of its options
/// that count where they are not given, an example and the exit statuses.
class CommandLine : public CLI::App {
 public:
  CommandLine(const std::string& name, const std::string& what, const std::string& example,
              const std::string& statuses = exit_statuses);
};

/// The same for a subcommand that is read with its program.
CLI::App& add_subcommand(CLI::App& app, const std::string& name, const std::string& what, const std::string& example,
                         const std::string& statuses = exit_statuses);

/// Reads the command line. Numbers are whole and finite, as their options want them. If the program shall end now, it
/// has written why, and this is its status: 0 after --help and --version, otherwise `wrong_usage`.
std::optional<int> read_command_line(CLI::App& app, int argc, char** argv, std::ostream& out, std::ostream& err);
std::optional<int> read_command_line(CLI::App& app, int argc, char** argv);

}  // namespace ilp::host
