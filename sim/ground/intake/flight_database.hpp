// What stays on board and is at hand after a flight on the host: the onboard database.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::ground {

/// Frames, overlaps, strips, keyframes, poses, depths, richness, products, events, components and storage, without
/// their blobs: it accounts for the flight and never stands in for what was downlinked. Opened read-only. Throws
/// std::runtime_error.
[[nodiscard]] std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database);

}  // namespace ilp::ground
