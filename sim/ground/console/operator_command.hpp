// Parses a line of the operator to a command.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/packets/tailoring.hpp"

namespace ilp::console {

struct OperatorCommand {
  enum class Kind : std::uint8_t { nothing, telecommand, show, uplink, passes, wait, help, quit };

  Kind kind = Kind::nothing;
  std::string words;  ///< the line as typed, for reports about it
  std::uint8_t service = 0, subtype = 0;
  std::vector<std::uint8_t> data;
  std::string report;  ///< name of the report to show
  std::string path;    ///< path of the file to send
  double seconds = 0;  ///< time to wait
};

/// Parses a line. `now`: time of the flight, UTC. Throws std::runtime_error that says what is wrong with the line and
/// how the command is written. Values that the flight would refuse, such as one out of range, are errors too.
[[nodiscard]] OperatorCommand parse_operator_command(const std::string& line, const Tailoring& tailoring, UtcNs now);

/// What the status `not_found` means for a command, and what to do; empty if the text of the status is sufficient.
[[nodiscard]] std::string missing_words(const OperatorCommand& command);

/// Completions of a line by one word, as whole lines: commands, parameters, choices, reports, components, functions.
[[nodiscard]] std::vector<std::string> complete_operator_line(const std::string& typed);

/// A line for each command: how it is written, and what it does.
[[nodiscard]] std::vector<std::string> operator_help();

}  // namespace ilp::console
