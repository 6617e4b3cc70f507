// Computes the byte limits of a keyframe's products from its richness index (paper 4.2; decisions.md, 11).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

struct BitPlan {
  ProductScheme scheme = ProductScheme::lossy_region;
  std::uint32_t grant_bytes = 0;  ///< ceiling of the whole file
  int layers = 1;
  double priority = 0;  ///< larger goes first
};

struct PlannedKeyframe {
  double richness = 0;           ///< 0 to 1
  std::uint32_t newly_seen = 0;  ///< pixels
  std::size_t pixels = 0;        ///< of the image
  /// The link's bytes per keyframe at the present rates of both; 0: not known, or no limit.
  double budget_bytes = 0;
};

/// Bits per newly seen pixel rise from the mission's floor to its ceiling with the index. If the link cannot carry
/// that, the ceiling falls until a keyframe of middle index and ordinary area takes twice its share of the link (rich
/// keyframes take from poor ones, and layers that find no place stay on board). The bits never fall below the floor.
/// Below the mission's bound, and if nothing new was seen, an image is a thumbnail, and no image gets less than that.
/// Above another bound, and on a link without a limit, the region is coded exactly.
/// The bytes never fall with the index, the area or the budget.
[[nodiscard]] BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, const PlannedKeyframe& keyframe);

/// The link's bytes per keyframe when keyframes come `interval_s` apart; 0 when the interval is not known (not
/// positive).
[[nodiscard]] double link_budget_bytes(const MissionParameters& mission, double interval_s);

}  // namespace ilp
