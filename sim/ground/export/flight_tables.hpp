// Makes tables of a flight for CSV files: keyframes, events, navigation, housekeeping.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/ground/export/table.hpp"
#include "sim/ground/map/balance.hpp"

namespace ilp::exports {

// One row per keyframe, for keyframes.csv and for the attributes of shapes.

/// Times are in seconds since the mission epoch. Sigmas are standard deviations along the axes of the strip's world, in
/// map units. `unit_length`: map units per strip unit. Cells without data are empty.
[[nodiscard]] std::vector<Column> keyframe_columns();
[[nodiscard]] std::vector<Cell> keyframe_row(const intake::Keyframe& keyframe, double unit_length);

/// The table of keyframes.csv: all keyframes of the flight, with poses in the strips' own axes and units, and with gain
/// and offset of their grey values in the orthoimage. These two are empty if the orthoimage does not show the keyframe,
/// or shows its grey values unchanged.
[[nodiscard]] Table keyframe_table(const intake::Flight& flight, const std::map<std::int64_t, map::Balance>& balance);

/// The table of events.csv: time in seconds since the mission epoch, component, name, severity, meaning, advice, and
/// source line.
[[nodiscard]] Table event_table(const intake::Flight& flight);

/// Writes keyframes.csv and events.csv into `folder`, and, if there is any content, navigation.csv, strip-frames.csv,
/// and housekeeping-components.csv, -storage.csv and -timing.csv with the fields of the records (docs/records.md).
/// Returns the names of the files. Throws std::runtime_error.
std::vector<std::string> write_flight_tables(const intake::Flight& flight,
                                             const std::map<std::int64_t, map::Balance>& balance,
                                             const std::filesystem::path& folder);

}  // namespace ilp::exports
