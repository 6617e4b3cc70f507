// Campaigns flown by small stand-ins for simulator and scorer, which count how often they are called.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::test {

struct CampaignEnd {
  int status = -1;  ///< of exit; -1: ended by a signal
  std::string messages;
};

class CampaignTest : public testing::Test {
 protected:
  CampaignTest();

  /// The body of a shell script: $scenario, $seed, $set (the last one) and $out are set; `calls` has got a line
  /// "SCENARIO SEED SET".
  void simulator(const std::string& body) const;
  /// $run is the flight's folder; what `echo` prints is score.json.
  void scorer(const std::string& body) const;
  void campaign(const std::string& text) const { (void)folder.write("c.ini", text); }

  [[nodiscard]] std::vector<std::string> command(const std::vector<std::string>& more = {}) const;
  [[nodiscard]] CampaignEnd run(const std::vector<std::string>& more = {}) const;
  /// The caller ends and awaits it.
  [[nodiscard]] pid_t start(const std::vector<std::string>& more = {}) const;
  [[nodiscard]] static CampaignEnd await(pid_t program);

  [[nodiscard]] std::vector<std::string> calls() const;
  [[nodiscard]] std::filesystem::path job(const std::string& name) const { return folder / "out" / "jobs" / name; }
  /// The field of a job's row in table.csv.
  [[nodiscard]] std::string field(const std::string& job, const std::string& column) const;

  ScratchFolder folder;
};

/// Polls; false after half a minute.
[[nodiscard]] bool comes_true(const std::function<bool()>& condition);

[[nodiscard]] std::vector<std::string> lines_of(const std::filesystem::path& file);

}  // namespace ilp::test
