// The campaigns of faults. Each prints its table in Markdown and answers whether its promise was kept.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/faults/trial.hpp"

namespace ilp::faults {

struct CampaignOptions {
  std::int64_t trials = 100;
  std::uint64_t seed = 1;
  std::int64_t only = -1;  ///< this trial alone, described in full
  int jobs = 2;
  std::string part;   ///< of the memory: only those whose names begin so
  bool list = false;  ///< every trial that is not as promised
  std::filesystem::path folder;
};

/// Single bits of the database and its log flip, between two boots or beneath a running one.
bool bits_in_storage(const Reference& reference, const CampaignOptions& options);
/// Calls of the operating system on the flight's files fail, below SQLite's VFS: one, several, or all for seconds, in
/// flight and at a start; with a reader or a held lock beside it; then an orderly end, a kill or a power cut, and a
/// start without faults. And flips in the files between two boots.
bool failing_files(const Reference& reference, const CampaignOptions& options);
/// Single bits of the flight's static memory flip, between steps and within them.
bool bits_in_memory(const Reference& reference, const CampaignOptions& options);
/// Every call of the store fails once; then single calls and bursts at random, of one component or of all; then a
/// store that fails for a minute.
bool failing_calls(const std::filesystem::path& world, const CampaignOptions& options, bool packets);

}  // namespace ilp::faults
