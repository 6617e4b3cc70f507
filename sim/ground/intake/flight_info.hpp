// The JSON file in which a run on the host says what it was and what it cost.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {

/// The cost of the run on the host; every value is optional.
struct FlightInfo {
  std::optional<double> wall_s, cpu_s, flight_cpu_s, peak_rss_mib, static_bytes;
  std::optional<double> frames, keyframes, seed, target_overlap;
  std::optional<double> binning;  ///< so many pixels of the photographs, in x and in y, were one that flew
  std::string profile, software, source;
  std::vector<std::string> notes;  ///< what the simulator said of its images and measurements
};

/// Members that are absent or of another type stay unknown. Throws std::runtime_error when the file is no JSON object.
[[nodiscard]] FlightInfo read_flight_info(const std::filesystem::path& path);

// Reads the onboard database, which is at hand after a flight on the host.

/// Frames, overlaps, strips, keyframes, poses, depths, richness, products, events, components and storage, without
/// their blobs: these records explain the flight and never replace data that did not come down. The database is opened
/// read-only. Throws std::runtime_error.
[[nodiscard]] std::vector<RecordEntry> read_flight_database(const std::filesystem::path& database);

/// The value to which a telecommand has set the parameter `section.key`; none if no telecommand has. Throws
/// std::runtime_error.
[[nodiscard]] std::optional<double> read_setting(const std::filesystem::path& database, const std::string& name);

}  // namespace ilp::intake
