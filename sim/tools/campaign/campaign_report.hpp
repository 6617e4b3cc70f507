// What a campaign leaves for its reader.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/job_grid.hpp"
#include "sim/tools/campaign/result_table.hpp"

namespace ilp::batch {

/// One page that needs no other file: what was flown, table, plots, failures with the ends of their logs.
[[nodiscard]] std::string report_html(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results,
                                      const std::filesystem::path& out);

/// table.csv, table.md, plots/*.svg and report.html in OUT. std::runtime_error names the file.
void write_report(const Campaign& campaign, const std::vector<Job>& jobs, const JobResults& results,
                  const std::filesystem::path& out);

}  // namespace ilp::batch
