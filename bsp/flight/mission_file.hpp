// Mission parameters from a file in the grammar of cfg/mission_text.hpp.
#pragma once

#include "cfg/mission_text.hpp"
#include "fsw/base/text.hpp"

namespace ilp {

/// What is wrong with an entry and what was expected: the range, the choices, or the parameter whose key is spelled
/// most like this one.
[[nodiscard]] FixedText<320> fault_of_entry(const MissionEntry& entry);

/// The fault that read_mission_file found in an entry or a line, or that there is no file; empty for another one, whose
/// Status says everything.
[[nodiscard]] FixedText<512> fault_of_mission(Status status, const MissionEntry& entry);

/// `mission` changes only when the whole file is right. `not_found` (a = 0) if there is no file, `io_error` if it
/// cannot be read, else the Status of MissionText; `fault` names the wrong entry.
Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault);

}  // namespace ilp
