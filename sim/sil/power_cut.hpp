// Power failures of a simulated flight: a new process replaces the running one and resumes from the store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "fsw/base/time.hpp"
#include "sim/sil/fault_plan.hpp"

namespace ilp::sil {

/// What the simulation knows of earlier boots of the flight. Kept in power.json beside the store.
struct PastBoots {
  std::int64_t random_cuts = 0;    ///< done so far
  std::int64_t timed_cuts = 0;     ///< done so far
  TimeNs clock_ns = 0;             ///< mission time of the last cut, from which the flight resumes
  std::int64_t store_refused = 0;  ///< FaultyStore::refused of all boots
  std::int64_t link_refused = 0;   ///< FaultyLink::refused of all boots
};

/// Reads power.json of the folder; all 0 without the file. Throws std::runtime_error if the file is damaged.
[[nodiscard]] PastBoots read_past_boots(const std::filesystem::path& folder);

/// The power is cut `writes` writes of the store after the minor frame that took the image with this sequence number
/// (0: after the start).
struct PowerCut {
  std::int64_t sequence = 0;
  std::int64_t writes = 0;
};

/// Draws `cuts` cuts from the seed, in the order of their sequence numbers, which lie in [0, frames).
[[nodiscard]] std::vector<PowerCut> plan_power_cuts(int cuts, std::uint64_t seed, std::int64_t frames);

/// Writes power.json and executes this program again with the added argument `--resume`. Nothing is closed, flushed or
/// rolled back.
[[noreturn]] void cut_power(const std::filesystem::path& folder, const PastBoots& boots);

}  // namespace ilp::sil
