// Events and housekeeping as CSV files.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/ground/export/table.hpp"

namespace ilp::exports {

/// Time in seconds since the mission epoch, component, name, severity, meaning, advice, place in the code.
[[nodiscard]] Table event_table(const intake::Flight& flight);

/// Writes into `folder`: keyframes.csv, events.csv, and, if there is any content, housekeeping-components.csv, -storage
/// and -timing with the fields of the records (docs/records.md). Returns their names; throws std::runtime_error.
std::vector<std::string> write_flight_tables(const intake::Flight& flight, const std::filesystem::path& folder);

}  // namespace ilp::exports
