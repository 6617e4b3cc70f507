// How much of the storage budget the memory of places may take.
#pragma once

#include <algorithm>
#include <cstdint>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"

namespace ilp {

/// With its blobs, whatever the image (fsw/places/place_memory.cpp asserts it).
inline constexpr std::int64_t most_place_bytes = limits::max_image_side > 1024 ? 190'000 : 140'000;

/// Places stay for the whole flight, while all other data go once the ground has them: the rest of the budget is always
/// left for these.
inline constexpr double place_share = 0.25;

/// How many places may be on record.
[[nodiscard]] inline std::size_t places_with_capacity(const MissionParameters& mission) {
  const double bytes = place_share * mission.storage_budget_mib * 1048576.0;
  const auto fitting = static_cast<std::int64_t>(bytes / static_cast<double>(most_place_bytes));
  return static_cast<std::size_t>(std::min<std::int64_t>(fitting, mission.places_kept));
}

}  // namespace ilp
