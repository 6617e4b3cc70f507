// Computes the byte limits of a keyframe's products from its richness index (paper 4.2; decisions.md, 11).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

struct BitPlan {
  ProductScheme scheme = ProductScheme::lossy_region;
  std::uint32_t grant_bytes = 0;  ///< ceiling of the whole file
  int layers = 1;
  double priority = 0;       ///< larger goes first
  bool region_only = false;  ///< the grant has no room for what surrounds the new part
};

struct PlannedKeyframe {
  double richness = 0;           ///< 0 to 1
  std::uint32_t newly_seen = 0;  ///< pixels
  std::size_t pixels = 0;        ///< of the image
  /// The link's bytes per keyframe at the present rates of both; 0: not known, or no limit.
  double budget_bytes = 0;
  double mean_budget_bytes = 0;  ///< the mean of it over the last keyframes
  double rank = 0.5;             ///< of its index in the flight so far (IndexRanks)
};

/// Bits per newly seen pixel rise from the mission's floor to its ceiling with the index. If the link cannot carry
/// that, the ceiling falls until a keyframe of middle index and ordinary area takes twice its share of the link (rich
/// keyframes take from poor ones, and layers that find no place stay on board). The bits never fall below the floor.
/// If nothing new was seen, nothing is granted. An image is a thumbnail if its index ranks among the lowest
/// thumbnail_share of the flight and the link is narrow: in the mean it carries less than a quarter of the way from the
/// floors to the ceilings. No image gets less than a thumbnail, or than its new part takes without loss. The region is
/// coded exactly if the index ranks among the highest lossless_share and the link carries the ceilings. The bytes never
/// fall with the index, the area or the budget.
[[nodiscard]] BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, const PlannedKeyframe& keyframe);

/// The link's bytes per keyframe when keyframes come `interval_s` apart; 0 when the interval is not known (not
/// positive).
[[nodiscard]] double link_budget_bytes(const MissionParameters& mission, double interval_s);

}  // namespace ilp
