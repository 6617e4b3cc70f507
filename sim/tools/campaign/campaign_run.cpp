#include "sim/tools/campaign/campaign_run.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <ctime>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>

#include "sim/host/digest.hpp"
#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"
#include "sim/tools/campaign/job_run.hpp"
#include "sim/tools/campaign/progress.hpp"

namespace ilp::batch {
namespace fs = std::filesystem;
namespace {

using Clock = JobRun::Clock;

/// Signals that end a campaign, and those of ended children, are waited for instead of handled.
class HeldSignals {
 public:
  HeldSignals() {
    sigemptyset(&held_);
    for (const int signal : {SIGCHLD, SIGINT, SIGTERM, SIGHUP}) sigaddset(&held_, signal);
    pthread_sigmask(SIG_BLOCK, &held_, &before_);
  }
  ~HeldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HeldSignals(const HeldSignals&) = delete;
  HeldSignals& operator=(const HeldSignals&) = delete;

  /// The signal that asks for the end; 0: a child ended, or the time is over.
  [[nodiscard]] int wait_until(Clock::time_point time) const {
    const auto left = std::max(Clock::duration::zero(), time - Clock::now());
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec span{seconds.count(), std::chrono::duration_cast<std::chrono::nanoseconds>(left - seconds).count()};
    const int signal = sigtimedwait(&held_, nullptr, &span);
    return signal > 0 && signal != SIGCHLD ? signal : 0;
  }

 private:
  sigset_t held_{}, before_{};
};

std::string bytes_of(const fs::path& file) {
  const std::vector<std::uint8_t> bytes = ground::read_file(file);
  return {bytes.begin(), bytes.end()};
}

fs::path program_path(const fs::path& program) {
  if (!fs::is_regular_file(program)) throw std::runtime_error("there is no program " + program.string());
  return fs::canonical(program);
}

fs::path folder_of(const Campaign& campaign) {
  return fs::absolute(campaign.file).parent_path();
}

/// Everything that a job's numbers depend on; the time limit, plots and columns are no part of it. Of a file that is
/// named, the bytes.
std::string inputs_digest(const Job& job, const fs::path& folder, std::uint64_t programs) {
  std::uint64_t state = programs;
  const auto add_file = [&](const std::string& name) {
    if (!name.empty() && fs::is_regular_file(folder / name)) state = sim::digest(bytes_of(folder / name), state);
  };
  for (const std::string& argument : flight_arguments(job)) state = sim::digest(argument + '\0', state);
  if (is_scenario_file(job.scenario)) add_file(job.scenario);
  for (const auto& setting : job.settings) add_file(setting.second);
  return sim::digest_text(state);
}

std::size_t strangers(const fs::path& folder, const std::vector<Job>& jobs) {
  std::set<std::string> names;
  for (const Job& job : jobs) names.insert(job.name);
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(folder)) count += names.count(entry.path().filename().string()) == 0;
  return count;
}

class Scheduler {
 public:
  Scheduler(const Campaign& campaign, const std::vector<Job>& jobs, const RunOptions& options, std::ostream& out)
      : jobs_(jobs), options_(options), out_(out), folder_(options.out / "jobs") {
    const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
    const int wanted = options.parallel > 0 ? options.parallel : campaign.jobs;
    parallel_ = wanted > 0 ? static_cast<std::size_t>(wanted) : cores;
    programs_ = {program_path(options.sil),
                 program_path(options.score),
                 folder_of(campaign),
                 campaign.timeout_s,
                 std::max<std::size_t>(1, cores / parallel_),
                 options.keep};
    const std::uint64_t contents = sim::digest(bytes_of(programs_.score), sim::digest(bytes_of(programs_.sil)));
    results_.jobs.resize(jobs.size());
    for (const Job& job : jobs) digests_.push_back(inputs_digest(job, folder_of(campaign), contents));
  }

  CampaignResults run() {
    take_earlier_results();
    Progress progress(out_, options_.terminal, jobs_.size(), jobs_.size() - pending_.size(), parallel_);
    const HeldSignals signals;
    std::size_t next = 0;
    while (results_.interrupted_by == 0 && (next < pending_.size() || !running_.empty())) {
      while (next < pending_.size() && running_.size() < parallel_) start(pending_[next++]);
      progress.tick(running_.size());
      results_.interrupted_by = signals.wait_until(next_look());
      step(progress);
    }
    progress.close();
    running_.clear();
    return std::move(results_);
  }

 private:
  struct Running {
    std::size_t index;
    JobRun run;
  };

  void take_earlier_results() {
    std::size_t changed = 0;
    for (std::size_t i = 0; i < jobs_.size(); ++i) {
      std::optional<JobResult> earlier = read_result(folder_ / jobs_[i].name / "result.json");
      const bool same = earlier && earlier->digest == digests_[i];
      if (earlier && !same && !earlier->digest.empty()) ++changed;
      if (same && (earlier->failure.empty() || !options_.retry_failed)) {
        results_.jobs[i] = std::move(earlier);
      } else {
        pending_.push_back(i);
      }
    }
    if (changed > 0) {
      out_ << ground::counted(changed, "earlier result") << " had other parameters or programs: run again\n";
    }
    if (const std::size_t count = strangers(folder_, jobs_); count > 0) {
      out_ << ground::counted(count, "folder") << " in " << folder_.string()
           << " of no flight of this campaign: left alone\n";
    }
  }

  void start(std::size_t index) {
    running_.push_back({index, JobRun(jobs_[index], folder_ / jobs_[index].name, programs_, digests_[index])});
  }

  [[nodiscard]] Clock::time_point next_look() const {
    Clock::time_point time = Clock::now() + std::chrono::seconds(1);
    for (const Running& running : running_) time = std::min(time, running.run.deadline());
    return time;
  }

  void step(Progress& progress) {
    std::vector<Running> still;
    for (Running& running : running_) {
      std::optional<JobResult> result = running.run.step();
      if (!result) {
        still.push_back(std::move(running));
        continue;
      }
      progress.ended(jobs_[running.index].name, result->failure);
      results_.jobs[running.index] = std::move(result);
    }
    running_.swap(still);
  }

  const std::vector<Job>& jobs_;
  const RunOptions& options_;
  std::ostream& out_;
  fs::path folder_;
  JobPrograms programs_;
  std::vector<std::string> digests_;
  std::size_t parallel_ = 1;
  std::vector<std::size_t> pending_;
  std::vector<Running> running_;
  CampaignResults results_;
};

}  // namespace

CampaignResults run_jobs(const Campaign& campaign, const std::vector<Job>& jobs, const RunOptions& options,
                         std::ostream& progress) {
  return Scheduler(campaign, jobs, options, progress).run();
}

}  // namespace ilp::batch
