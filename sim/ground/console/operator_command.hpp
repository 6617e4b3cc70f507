// Turns an operator's line into telecommands.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fsw/packets/tailoring.hpp"

namespace ilp::console {

struct OperatorCommand {
  enum class Kind : std::uint8_t { nothing, telecommand, show, uplink, passes, wait, help, quit };

  Kind kind = Kind::nothing;
  std::string words;  ///< as typed, for reports about it
  std::uint8_t service = 0, subtype = 0;
  std::vector<std::uint8_t> data;
  std::string report;  ///< that is to be shown
  std::string path;    ///< of a file to send
  double seconds = 0;  ///< to wait
};

/// `now` is the time of the flight, in UTC. Throws std::runtime_error that says what is wrong with the line and how the
/// command is written; what the flight would refuse, a value out of range for example, is refused here.
[[nodiscard]] OperatorCommand parse_operator_command(const std::string& line, const Tailoring& tailoring, UtcNs now);

/// What a command means that failed with `not_found`, and what to do; empty where the status says it itself.
[[nodiscard]] std::string missing_words(const OperatorCommand& command);

/// Lines that begin as the given one, by a word more: commands, parameters, choices, reports, components, functions.
[[nodiscard]] std::vector<std::string> complete_operator_line(const std::string& typed);

/// A line for each command: how it is written, and what it does.
[[nodiscard]] std::vector<std::string> operator_help();

}  // namespace ilp::console
