// Mission parameters from a file in the grammar of cfg/mission_text.hpp.
#pragma once

#include "cfg/mission_text.hpp"

namespace ilp {

/// All or nothing: `mission` is changed only when the whole file is right. `not_found` (a = 0) where there is no file,
/// `io_error` for one that cannot be read, `parameters_contradict` (a = relation, docs/commanding.md), else the Status
/// of MissionText, with a = line; `fault` says which entry is wrong.
Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault);

}  // namespace ilp
