// The files of a run's results, and those of an earlier run in the same folder, which must not be taken for parts of
// it.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"
#include "sim/ground/run_record.hpp"

namespace ilp::ground {

/// Whether other results have the same: a PFM file, model.ply or the catalogue.
[[nodiscard]] bool is_copy(const std::string& name);
/// All files that the run has written or kept, by their names below the folder; without copies where the report says
/// so.
[[nodiscard]] std::vector<std::string> result_files(const report::Report& report);
/// Of the map of a strip alone: what export_grid and export_map leave.
[[nodiscard]] std::vector<std::string> map_files(const report::StripResult& strip);

/// The pages say what the other files are: without them the results are those of a run that has not ended.
void remove_pages(const std::filesystem::path& folder);

/// Removes the files of the earlier run that are none of `files`, and those that carry exactly the names that this
/// program gives; anything else in the folder stays.
void remove_other_results(const std::filesystem::path& folder, const std::vector<std::string>& files,
                          const RunRecord& before);

}  // namespace ilp::ground
