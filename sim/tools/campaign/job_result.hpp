// What a job has left: its score, or why there is none.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ilp::batch {

struct Score {
  bool complete = false;
  std::map<std::string, std::optional<double>> summary;
  std::vector<std::string> remarks;
};

/// score.json of the scoring program. std::runtime_error says what is wrong with the file.
[[nodiscard]] Score read_score(const std::filesystem::path& file);

struct JobResult {
  std::string digest;   ///< of all that the result depends on; empty: not to be relied on, run again
  std::string failure;  ///< empty: the job has a score
  double seconds = 0;   ///< wall clock, of flight and score together
  Score score;
};

/// Whole or not at all; the parent folder exists. std::runtime_error when it cannot be written.
void write_result(const std::filesystem::path& file, const JobResult& result);
/// Empty when there is no file or not a whole one.
[[nodiscard]] std::optional<JobResult> read_result(const std::filesystem::path& file);

}  // namespace ilp::batch
