// Power failures of a simulated flight: the process is replaced by a fresh one that resumes from the store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "fsw/base/time.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// What the simulation remembers of earlier runs of the flight. It is kept beside the store, in power.json.
struct PastBoots {
  std::int64_t random_cuts = 0;
  std::int64_t timed_cuts = 0;
  TimeNs clock_ns = 0;  ///< mission time goes on here
  std::int64_t store_refused = 0;
  std::int64_t link_refused = 0;
};

/// All zero where there is no file; std::runtime_error for a file that is none of ours.
[[nodiscard]] PastBoots read_past_boots(const std::filesystem::path& folder);

/// The cut comes `writes` writes of the store after the minor frame that took this image (0: after the start).
struct PowerCut {
  std::int64_t sequence = 0;
  std::int64_t writes = 0;
};

/// Cuts in the order of their sequence numbers, which lie in [0, frames).
[[nodiscard]] std::vector<PowerCut> plan_power_cuts(int cuts, std::uint64_t seed, std::int64_t frames);

/// Writes power.json and executes this program again, with `--resume` after its arguments. Nothing is closed, flushed
/// or rolled back.
[[noreturn]] void cut_power(const std::filesystem::path& folder, const PastBoots& boots);

}  // namespace ilp::sil
