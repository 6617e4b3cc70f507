// Mission parameters of the subcommands that run the flight's components.
#pragma once

#include <string>

#include "cfg/mission.hpp"

namespace ilp::host {

/// Those of the file; an empty name stands for the default mission. std::runtime_error names the file and, where one
/// entry of it is wrong, the entry.
[[nodiscard]] MissionParameters read_mission(const std::string& file);

}  // namespace ilp::host
