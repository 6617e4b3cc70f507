// Tables of a flight as CSV files: keyframes, events, navigation, housekeeping.
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

/// Times are seconds since the mission epoch, sigmas one standard deviation along the axes of the strip's world in
/// `unit_length` (map units per strip unit); cells without data are empty.
[[nodiscard]] std::vector<Column> keyframe_columns();
[[nodiscard]] std::vector<Cell> keyframe_row(const intake::Keyframe& keyframe, double unit_length);

/// keyframes.csv: all keyframes of the flight, with their poses in the strips' own axes and units, and with the gain
/// and offset by which the orthoimage shows their grey; empty where it shows none, or grey as it is.
[[nodiscard]] Table keyframe_table(const intake::Flight& flight, const std::map<std::int64_t, map::Balance>& balance);

/// Time in seconds since the mission epoch, component, name, severity, meaning, advice, place in the code.
[[nodiscard]] Table event_table(const intake::Flight& flight);

/// Writes into `folder`: keyframes.csv, events.csv, and, if there is any content, navigation.csv, strip-frames.csv and
/// housekeeping-components.csv, -storage and -timing with the fields of the records (docs/records.md). Returns their
/// names; throws std::runtime_error.
std::vector<std::string> write_flight_tables(const intake::Flight& flight,
                                             const std::map<std::int64_t, map::Balance>& balance,
                                             const std::filesystem::path& folder);

}  // namespace ilp::exports
