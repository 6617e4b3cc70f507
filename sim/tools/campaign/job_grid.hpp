// The flights of a campaign: the cartesian products of its grids.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim/tools/campaign/campaign_file.hpp"

namespace ilp::batch {

inline constexpr std::size_t most_jobs = 10000;

struct Job {
  std::string name;  ///< fit for a folder; follows from the grid's name and the values of its axes alone
  std::string grid;
  std::vector<std::pair<std::string, std::string>> axes;      ///< key and value, in the file's order
  std::vector<std::pair<std::string, std::string>> settings;  ///< section.name and value, sorted by name
  std::string scenario;                                       ///< a preset, an absolute path, or empty
  std::uint64_t seed = 1;
  int frames = 0;  ///< 0: the simulator's own number
};

/// The last axis runs fastest. std::runtime_error for more than `most_jobs`.
[[nodiscard]] std::vector<Job> expand(const Campaign& campaign);

/// For the simulator, without the program and the folder.
[[nodiscard]] std::vector<std::string> flight_arguments(const Job& job);

/// nullptr: the job has no such axis.
[[nodiscard]] const std::string* axis_value(const Job& job, const std::string& key);

/// The job's axes without the seed: what its table row is called.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> cell_of(const Job& job);

}  // namespace ilp::batch
