// Mission parameters that were set by telecommand: stored, and applied over the mission file at every start.
#pragma once

#include "cfg/mission.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Writes every setting into `mission`. Together they must be valid, or none is used. `setting_ignored` (a = the first
/// parameter at fault, b = the relation) when some or all were left out: the flight continues with the rest.
Status load_settings(Reader<SettingRecord> store, MissionParameters& mission);

/// Writes the record of a setting, in an open transaction.
Status write_setting(StorePart<Writes<SettingRecord>> store, std::size_t index, double value, TimeNs now);

}  // namespace ilp
