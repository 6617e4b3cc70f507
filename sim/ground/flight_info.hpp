// The JSON file in which a run on the host says what it was and what it cost.
#pragma once

#include <filesystem>

#include "sim/ground/report.hpp"

namespace ilp::ground {

/// Members that are absent or of another type stay unknown. Throws std::runtime_error when the file is no JSON object.
[[nodiscard]] FlightInfo read_flight_info(const std::filesystem::path& path);

}  // namespace ilp::ground
