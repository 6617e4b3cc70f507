// Mission parameters that were set by telecommand: kept in the store, and put above the mission file at every start.
#pragma once

#include "cfg/mission.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Puts every setting into `mission`; together they must be valid, or none is. `setting_ignored` (a = the first
/// parameter at fault, b = the relation) when some or all were left out: the flight goes on with what it has.
Status load_settings(Reader<SettingRecord> store, MissionParameters& mission);

/// The record of a setting; in an open transaction.
Status write_setting(StorePart<Writes<SettingRecord>> store, std::size_t index, double value, TimeNs now);

}  // namespace ilp
