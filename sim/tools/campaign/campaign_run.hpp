// All jobs of a campaign in parallel processes, resumable.
#pragma once

#include <filesystem>
#include <optional>
#include <ostream>
#include <vector>

#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/job_grid.hpp"
#include "sim/tools/campaign/job_result.hpp"

namespace ilp::batch {

struct RunOptions {
  std::filesystem::path out;         ///< new, empty, or of the same campaign
  std::filesystem::path sil, score;  ///< the two programs
  int parallel = 0;                  ///< 0: as the campaign says, else one for each core
  bool keep = false;                 ///< images, truth, database and outbox of every flight
  bool retry_failed = false;
  bool terminal = false;  ///< progress goes to one
};

struct CampaignResults {
  std::vector<std::optional<JobResult>> jobs;  ///< as the jobs given; empty: not run
  int interrupted_by = 0;                      ///< signal; 0: none
};

/// Runs what has no result of the same inputs: arguments, the files they name (not what those name in turn), and both
/// programs. SIGINT, SIGTERM and SIGHUP
/// stop it within moments, without a process left behind; until it returns they are blocked for this thread. Works in
/// OUT/jobs, under the lock OUT/.lock. std::runtime_error when it cannot work there.
[[nodiscard]] CampaignResults run_jobs(const Campaign& campaign, const std::vector<Job>& jobs,
                                       const RunOptions& options, std::ostream& progress);

}  // namespace ilp::batch
