// Lists the files of a run's results, and removes those of an earlier run from the same folder, so that nobody takes
// them for results of this run.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim/ground/report/report.hpp"
#include "sim/ground/run_record.hpp"

namespace ilp::ground {

/// Whether other result files have the same content in another format, or the file can be made again: true for PFM
/// files, model*.ply and the catalogue.
[[nodiscard]] bool is_copy(const std::string& name);
/// Names, relative to the results' folder, of all files that the run has written or kept. Copies (is_copy) are left out
/// unless `report.with_copies`.
[[nodiscard]] std::vector<std::string> result_files(const report::Report& report);
/// The same for the map of one strip: the files of export_grid and export_map. Empty for a strip without a map.
[[nodiscard]] std::vector<std::string> map_files(const report::StripResult& strip);

/// Removes report.json, report.html and viewer.html. A folder without them holds the results of a run that has not
/// ended.
void remove_pages(const std::filesystem::path& folder);

/// Removes files that are not among `files`, if the record `before` lists them or their names follow the patterns of
/// this program's results. All other files in the folder stay.
void remove_other_results(const std::filesystem::path& folder, const std::vector<std::string>& files,
                          const RunRecord& before);

}  // namespace ilp::ground
