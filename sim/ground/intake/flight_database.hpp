// Reads the onboard database, which is at hand after a flight on the host.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {

/// Frames, overlaps, strips, keyframes, poses, depths, richness, products, events, components and storage, without
/// their blobs: these records explain the flight and never replace data that did not come down. The database is opened
/// read-only. Throws std::runtime_error.
[[nodiscard]] std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database);

}  // namespace ilp::intake
