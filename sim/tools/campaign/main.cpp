// ilp-campaign: many simulated flights in parallel, scored, in one table and report.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>

#include "sim/host/text_format.hpp"
#include "sim/tools/campaign/campaign_file.hpp"
#include "sim/tools/campaign/campaign_folder.hpp"
#include "sim/tools/campaign/campaign_report.hpp"
#include "sim/tools/campaign/campaign_run.hpp"
#include "sim/tools/campaign/job_grid.hpp"

namespace {

using namespace ilp::batch;
namespace fs = std::filesystem;

void list(const std::vector<Job>& jobs) {
  for (const Job& job : jobs) {
    std::cout << job.name << ":";
    for (const std::string& argument : flight_arguments(job)) std::cout << " " << argument;
    std::cout << "\n";
  }
}

/// 0: every flight has a score, 1: some failed, 128 + signal: interrupted.
int fly(const Campaign& campaign, const std::vector<Job>& jobs, const RunOptions& options) {
  const CampaignFolder folder(campaign, options.out);
  const CampaignResults results = run_jobs(campaign, jobs, options, std::cerr);
  write_report(campaign, jobs, results.jobs, folder.path());
  const auto failed = std::count_if(results.jobs.begin(), results.jobs.end(),
                                    [](const auto& result) { return result && !result->failure.empty(); });
  if (failed > 0) std::cerr << failed << " of " << ilp::ground::counted(jobs.size(), "flight") << " failed\n";
  if (results.interrupted_by != 0) std::cerr << "Interrupted: the same command goes on where this one stopped\n";
  std::cout << "Report: " << (folder.path() / "report.html").string() << std::endl;
  if (results.interrupted_by != 0) return 128 + results.interrupted_by;
  return failed > 0 ? 1 : 0;
}

int run(int argc, char** argv) {
  CLI::App app{"Flies a campaign: a grid of simulated flights in parallel processes, each scored; resumable"};
  std::string file;
  RunOptions options;
  bool only_list = false;
  const fs::path beside = fs::read_symlink("/proc/self/exe").parent_path();
  options.sil = beside / "ilp-sil";
  options.score = beside / "ilp-score";
  app.add_option("file", file, "campaign file (sim/tools/campaign/campaign_file.hpp says what stands in it)")
      ->required();
  app.add_option("--out", options.out, "folder of the campaign; one that was interrupted goes on there");
  app.add_option("--jobs", options.parallel, "flights at a time (default: the campaign's, else one for each core)")
      ->check(CLI::Range(1, 1024));
  app.add_option("--sil", options.sil, "the simulator (default: ilp-sil beside this program)")->take_last();
  app.add_option("--score", options.score, "the scoring program (default: ilp-score beside this program)")->take_last();
  app.add_flag("--keep", options.keep, "keep images, truth, database and outbox of every flight");
  app.add_flag("--retry-failed", options.retry_failed, "run failed flights again");
  app.add_flag("--list", only_list, "print the flights and their arguments, and exit");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const Campaign campaign = read_campaign(file);
  const std::vector<Job> jobs = expand(campaign);
  if (only_list) {
    list(jobs);
    return 0;
  }
  if (options.out.empty()) throw std::runtime_error("--out DIR is needed: where the campaign leaves its results");
  options.out = fs::absolute(options.out);
  options.terminal = isatty(STDERR_FILENO) != 0;
  return fly(campaign, jobs, options);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ilp-campaign: %s\n", error.what());
    return 2;
  }
}
