// One job from its empty folder to its result: the flight, then its score, each a process of its own.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>

#include "sim/tools/campaign/job_grid.hpp"
#include "sim/tools/campaign/job_result.hpp"

namespace ilp::batch {

struct JobPrograms {
  std::filesystem::path sil, score;  ///< absolute
  std::filesystem::path folder;      ///< where they run: paths among the parameters are relative to it
  double timeout_s = 900;            ///< of both together
  std::size_t threads = 1;           ///< that each simulator renders with; no result depends on it
  bool keep = false;                 ///< images, truth, database and outbox of a scored flight
};

/// The folder holds command.txt, log.txt, and in the end result.json, written last; of a scored flight also score.json
/// and flight-info.json. The flight's own folder is `run` below it: removed once scored, there for inspection if not.
class JobRun {
 public:
  using Clock = std::chrono::steady_clock;

  /// Empties the folder. std::runtime_error when it cannot be written.
  JobRun(const Job& job, std::filesystem::path folder, const JobPrograms& programs, std::string digest);
  /// A job that has not ended leaves no process behind.
  ~JobRun();
  JobRun(JobRun&& other) noexcept;
  JobRun& operator=(JobRun&&) = delete;

  /// Never waits; empty while the job runs. After a result the job is over.
  [[nodiscard]] std::optional<JobResult> step();
  [[nodiscard]] Clock::time_point deadline() const { return deadline_; }

 private:
  enum class Stage { flight, score, over };

  JobResult collect();
  JobResult fail(const std::string& failure);
  JobResult finish(JobResult result);

  std::filesystem::path folder_;
  const JobPrograms* programs_;
  std::string digest_;
  Clock::time_point begin_, deadline_;
  Stage stage_ = Stage::over;
  pid_t process_ = 0;
  std::string start_fault_;
};

/// The last lines of a file, at most `bytes` of them; empty when there is none.
[[nodiscard]] std::string tail_of(const std::filesystem::path& file, std::size_t bytes);

}  // namespace ilp::batch
