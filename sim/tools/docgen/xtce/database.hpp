// The XTCE 1.2 database of a mission: every telecommand, report, event, housekeeping value and parameter, from the rows
// that the flight software itself follows. docs/commanding.md shows how ground systems load it.
#pragma once

#include <string>

#include "cfg/mission.hpp"

namespace ilp::docgen {

/// Widths, time and APID are those of the mission's `[link]` section. The same bytes on every machine. `flat`: one
/// SpaceSystem, for readers that know no others in it; `/` within a path is then `_`.
[[nodiscard]] std::string xtce_database(const MissionParameters& mission, bool flat = false);

}  // namespace ilp::docgen
