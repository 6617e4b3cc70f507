// Mission parameters from an .ini file: [section] key = value, ';' and '#' begin comments.
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Where a mission file is wrong, for the message to its author.
struct MissionFileError {
  char section[32] = {};
  char key[48] = {};
  char value[32] = {};
};

/// All or nothing: `mission` is changed only when the whole file is right. `not_found` where there is no file,
/// `io_error` for one that cannot be read, `parse_error` (a = line) for a malformed line, one of more than 198 octets
/// or one that is no text, `parameters_contradict` (a = relation, docs/commanding.md), else the Status of
/// set_parameter; `error` says which entry.
Status read_mission_file(const char* path, MissionParameters& mission, MissionFileError& error);

}  // namespace ilp
