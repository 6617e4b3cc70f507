// The output of a task: a file for each result, named by the digest of the result's inputs. A file is complete or
// absent, so that a task may be killed at any time and repeated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/tasks/work_package.hpp"

namespace ilp::tasks {

/// Folder of packages and results of tasks, in the folder of a run's results. All machines must have access to it.
[[nodiscard]] std::filesystem::path work_folder(const std::filesystem::path& out);

struct WorkResult {
  WorkKind kind = WorkKind::quick_looks;
  std::int64_t owner = 0;                    ///< id of the quick-look's keyframe or of the tile's strip
  intake::TilePlace place;                   ///< position of a tile
  std::uint64_t digest = 0;                  ///< digest of the result's inputs; key in the catalogue
  std::vector<std::uint8_t> summary, cells;  ///< content; a quick-look has no cells
};

/// File name of a result.
[[nodiscard]] std::string name_of(WorkKind kind, std::int64_t owner, std::uint64_t digest);
[[nodiscard]] bool has_result(const std::filesystem::path& folder, const std::string& name);
/// Throws std::runtime_error if the file cannot be written.
void write_result(const WorkResult& result, const std::filesystem::path& folder);

struct TakenIn {
  std::size_t results = 0;  ///< results that are in the catalogue now
  std::size_t damaged = 0;  ///< damaged files; their work is done again
};
/// Moves the results in the work folder of `out` into the catalogue. `progress` gets the number of results done and of
/// all results.
TakenIn take_in_results(const std::filesystem::path& out, intake::Catalogue& catalogue,
                        const std::function<void(std::size_t, std::size_t)>& progress);

}  // namespace ilp::tasks
