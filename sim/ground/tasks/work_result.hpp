// What a task leaves: a file for each piece of its work, named by the digest of what the result depends on. A file is
// whole or absent, so that a task may be killed at any time, and repeated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/tasks/work_package.hpp"

namespace ilp::tasks {

/// Below the folder of a run's results, which all machines see.
[[nodiscard]] std::filesystem::path work_folder(const std::filesystem::path& out);

struct WorkResult {
  WorkKind kind = WorkKind::quick_looks;
  std::int64_t owner = 0;                    ///< keyframe of a quick-look, strip of a tile
  intake::TilePlace place;                   ///< of a tile
  std::uint64_t digest = 0;                  ///< of all that the result depends on, as the catalogue knows it
  std::vector<std::uint8_t> summary, cells;  ///< a quick-look has no cells
};

[[nodiscard]] std::string name_of(WorkKind kind, std::int64_t owner, std::uint64_t digest);
[[nodiscard]] bool has_result(const std::filesystem::path& folder, const std::string& name);
/// Throws std::runtime_error when the file cannot be written.
void write_result(const WorkResult& result, const std::filesystem::path& folder);

struct TakenIn {
  std::size_t results = 0;
  std::size_t damaged = 0;  ///< files that are not whole; their work is done again
};
/// Moves the results below the work folder of `out` into the catalogue. `progress` gets the number of results done and
/// of all.
TakenIn take_in_results(const std::filesystem::path& out, intake::Catalogue& catalogue,
                        const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace ilp::tasks
