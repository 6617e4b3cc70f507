// Counts of outcomes by group, as a table in Markdown.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "tests/faults/campaigns.hpp"
#include "tests/faults/trial.hpp"

namespace ilp::faults {

/// What a trial did, for the table and for repeating it. Lies in shared memory.
struct TrialRecord {
  Verdict verdict;
  char group[64] = {};  ///< row of the table
  char what[240] = {};  ///< where the fault was
};

struct TableOptions {
  const char* heading = "";
  std::vector<std::string> order{};  ///< of rows; others follow by name
  bool ends_are_faults = true;       ///< a crash or a hang breaks the promise, though the flight went on after it
  std::string measured{};            ///< rows that end so: what is silent there is counted, and breaks no promise
  bool losses_are_faults = false;    ///< nothing may be missing either
  bool below_the_store = false;      ///< counts Verdict::refused_valid and confirmed_lost, which break the promise
  bool list = false;                 ///< every trial that broke it
};

/// False when a trial broke the promise: silent, locked out, or broken.
bool print_table(const TrialRecord* records, std::int64_t trials, const TableOptions& options);
void print_trial(std::int64_t number, const TrialRecord& record);

/// All trials in several processes, and their table; or the one that the options name, described in full.
bool run_campaign(const CampaignOptions& options, const TableOptions& table,
                  const std::function<void(std::int64_t, int, TrialRecord&)>& trial);

}  // namespace ilp::faults
