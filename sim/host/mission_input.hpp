// Mission parameters of programs that run the flight's components.
#pragma once

#include <string>
#include <vector>

#include "cfg/mission.hpp"

namespace ilp::host {

/// `mission`, changed as the file says; an empty name is no file. std::runtime_error names the file and, where one
/// entry of it is wrong, the entry with the range or the nearest name.
[[nodiscard]] MissionParameters read_mission(const std::string& file, MissionParameters mission = {});

/// std::runtime_error, as of read_mission, for a file that no flight takes. Whether its values contradict those of a
/// flight, only the flight knows.
void check_mission_lines(const std::string& file);

/// What is said of a parameter's key that does not exist, with the nearest one and its section.
[[nodiscard]] std::string unknown_parameter(const std::string& key);

/// What is said of a value that the parameter cannot have: its range or its choices.
[[nodiscard]] std::string fault_of_value(const ParameterInfo& info, const std::string& value);

/// section.key of every parameter, in the order of their numbers.
[[nodiscard]] std::vector<std::string> parameter_names();

}  // namespace ilp::host
