// Reads what only a flight on the host leaves: a JSON file about the run and its cost, and the onboard database.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {

/// Content of the JSON file; every value is optional.
struct FlightInfo {
  std::optional<double> wall_s, cpu_s, flight_cpu_s, peak_rss_mib, static_bytes;
  std::optional<double> frames, keyframes, seed, target_overlap;
  std::optional<double> binning;  ///< side of the block of photograph pixels that makes one pixel of a frame
  std::string profile, software, source;
  std::vector<std::string> notes;  ///< remarks of the simulator on its images and measurements
};

/// Reads the file; members that it lacks, or that have another type, stay empty. Throws std::runtime_error if the file
/// has no JSON object.
[[nodiscard]] FlightInfo read_flight_info(const std::filesystem::path& path);

// The onboard database, which is available after a flight on the host.

/// Reads the records of frames, overlaps, strips, keyframes, poses, depths, richness, products, events, components and
/// storage, without their blobs. They explain the flight, and do not replace data that did not come down. Opens the
/// database read-only. Throws std::runtime_error.
[[nodiscard]] std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database);

/// The value to which a telecommand has set the parameter `name`, which is section.key; none if no telecommand has set
/// it. Throws std::runtime_error.
[[nodiscard]] std::optional<double> read_setting(const std::filesystem::path& database, const std::string& name);

}  // namespace ilp::intake
