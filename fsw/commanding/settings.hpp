// Stores mission parameters that were set by telecommand. At every start they replace those of the mission file.
#pragma once

#include "cfg/mission.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Writes all valid settings of the store into `mission`. Returns `setting_ignored` (first value: number of a
/// parameter) if some were left out, and `setting_ignored` (second value: Relation) if all were left out because they
/// contradict each other. The flight continues in both cases.
Status load_settings(Reader<SettingRecord> store, MissionParameters& mission);

/// Writes the record of the setting of parameter `index`, in an open transaction.
Status write_setting(StorePart<Writes<SettingRecord>> store, std::size_t index, double value, TimeNs now);

}  // namespace ilp
