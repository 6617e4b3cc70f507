// Reads mission files for host programs, and words the errors in their entries.
#pragma once

#include <string>
#include <vector>

#include "cfg/mission.hpp"

namespace ilp::host {

/// Returns `mission` with the values of the file; unchanged for an empty file name. Throws std::runtime_error that
/// names the file and, if an entry is wrong, the entry with its range or the nearest parameter name.
[[nodiscard]] MissionParameters read_mission(const std::string& file, MissionParameters mission = {});

/// Throws as read_mission does for a file that no flight accepts. Contradictions between parameters are not checked,
/// because they depend on the other parameters of the flight.
void check_mission_lines(const std::string& file);

/// Error text for an unknown key, with the nearest known key and its section.
[[nodiscard]] std::string unknown_parameter(const std::string& key);

/// Error text for a value that the parameter cannot have, with its range or its choices.
[[nodiscard]] std::string fault_of_value(const ParameterInfo& info, const std::string& value);

/// `section.key` of every parameter, in the order of the parameter numbers.
[[nodiscard]] std::vector<std::string> parameter_names();

}  // namespace ilp::host
