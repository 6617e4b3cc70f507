// Reads mission parameters from a file in the grammar of cfg/mission_text.hpp, and describes errors in it.
#pragma once

#include "cfg/mission_text.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

/// Says what is wrong with an entry and what was expected: the range, the choices, or the parameter with the most
/// similar key.
[[nodiscard]] FixedText<320> fault_of_entry(const MissionEntry& entry);

/// Says which entry or line read_mission_file() has refused, or that there is no file. Empty for other statuses, whose
/// own text suffices.
[[nodiscard]] FixedText<512> fault_of_mission(Status status, const MissionEntry& entry);

/// Reads the file into `mission`, which changes only if the complete file is correct. Returns `not_found` if the file
/// cannot be opened, `io_error` if it cannot be read, else the Status of MissionText. `fault` becomes the wrong entry.
Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault);

}  // namespace ilp
