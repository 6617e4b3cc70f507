// The number of places that the memory of places may keep, and its share of the storage budget.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"

namespace ilp {

/// Most bytes of one place with its blobs (asserted by fsw/places/place_memory.cpp).
inline constexpr std::int64_t most_place_bytes = limits::max_image_side > 1024 ? 190'000 : 140'000;

/// The largest share of the storage budget that places may take. Places stay for the whole flight. The rest of the
/// budget is left for all other data, which are released once the ground has them.
inline constexpr double place_share = 0.25;

/// The number of places that may be on record.
[[nodiscard]] inline std::size_t places_with_capacity(const MissionParameters& mission) {
  const double bytes = place_share * mission.storage_budget_mib * 1048576.0;
  const auto fitting = static_cast<std::int64_t>(bytes / static_cast<double>(most_place_bytes));
  return static_cast<std::size_t>(std::min<std::int64_t>(fitting, mission.places_kept));
}

}  // namespace ilp
