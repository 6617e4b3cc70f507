// Generates the XTCE 1.2 database of a mission with all telecommands, reports, events, housekeeping values and
// parameters, from the tables that the flight software itself uses. docs/commanding.md shows how ground systems load
// it.
#pragma once

#include <string>

#include "cfg/mission.hpp"

namespace ilp::docgen {

/// The database as XML. Widths, time code and APID are those of the mission's `[link]` section. The bytes are the same
/// on every machine. `flat`: a single SpaceSystem, for readers that do not support nested ones; names then have `_` in
/// place of the `/` of paths.
[[nodiscard]] std::string xtce_database(const MissionParameters& mission, bool flat = false);

}  // namespace ilp::docgen
