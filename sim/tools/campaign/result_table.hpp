// The numbers of a campaign: every job for programs, cells over seeds for people.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/job_grid.hpp"
#include "sim/tools/campaign/job_result.hpp"
#include "sim/tools/campaign/summary_keys.hpp"

namespace ilp::batch {

using JobResults = std::vector<std::optional<JobResult>>;

/// One row for each job in the order of the grids: its axes, done, failed or not run, all numbers of the scores in full
/// precision. Empty where there is no number. RFC 4180, with a header.
[[nodiscard]] std::string table_csv(const std::vector<Job>& jobs, const JobResults& results);

/// Flights that differ in nothing but the seed.
struct TableCell {
  std::vector<std::size_t> jobs;  ///< indices
  std::size_t scored = 0;
};

struct CellTable {
  std::string grids;  ///< their names, separated by commas
  std::vector<std::string> axes;
  std::vector<TableCell> cells;  ///< in the order of their first jobs
};

/// Grids behind each other with the same axes share a table.
[[nodiscard]] std::vector<CellTable> cell_tables(const std::vector<Job>& jobs, const JobResults& results);

/// Of the flights that have the number.
struct CellNumber {
  std::size_t count = 0;
  double mean = 0, worst = 0;  ///< NaN where there is none
};
[[nodiscard]] CellNumber cell_number(const TableCell& cell, const JobResults& results, const SummaryKey& key);

/// "1.23 (2.34)", mean and worst; " of 2" behind it where not every scored flight of the cell has the number.
[[nodiscard]] std::string cell_text(const TableCell& cell, const JobResults& results, const SummaryKey& key);

/// "3", or "2 of 3" where some have no score.
[[nodiscard]] std::string flights_text(const TableCell& cell);

/// The campaign's columns, mean and worst over the seeds.
[[nodiscard]] std::string table_markdown(const Campaign& campaign, const std::vector<Job>& jobs,
                                         const JobResults& results);

}  // namespace ilp::batch
