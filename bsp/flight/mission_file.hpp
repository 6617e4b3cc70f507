// Mission parameters from a file in the grammar of cfg/mission_text.hpp.
#pragma once

#include "cfg/mission_text.hpp"

namespace ilp {

/// `mission` changes only when the whole file is right. `not_found` (a = 0) if there is no file, `io_error` if it
/// cannot be read, else the Status of MissionText; `fault` names the wrong entry.
Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault);

}  // namespace ilp
