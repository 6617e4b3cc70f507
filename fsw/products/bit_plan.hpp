// Computes the byte limits of a keyframe's products from its richness index (paper 4.2; decisions.md, 11).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

struct BitPlan {
  ProductScheme scheme = ProductScheme::lossy_region;
  std::uint32_t grant_bytes = 0;  ///< most bytes of the file
  int layers = 1;
  double priority = 0;       ///< products with larger values are sent first
  bool region_only = false;  ///< the grant does not suffice for the surroundings of the newly seen part
};

struct PlannedKeyframe {
  double richness = 0;           ///< Image Richness Index, 0 to 1
  std::uint32_t newly_seen = 0;  ///< newly seen pixels
  std::size_t pixels = 0;        ///< pixels of the image
  /// link_budget_bytes() at the present interval of keyframes; 0: not known, or no limit.
  double budget_bytes = 0;
  double mean_budget_bytes = 0;  ///< the same at the mean interval of the last keyframes
  double rank = 0.5;             ///< rank of the index in the flight so far (IndexRanks)
};

/// Plans the bytes of one product:
/// - The bits per newly seen pixel rise with the index from the mission's floor to its ceiling. If the link cannot
///   carry that, the ceiling is lowered until a keyframe of medium index and ordinary area takes twice its share of the
///   link. (Rich keyframes use the share of poor ones, and layers that are not sent stay on board.) The bits are never
///   below the floor. If nothing new was seen, no bytes are granted.
/// - An image is a thumbnail if its index is among the lowest thumbnail_share of the flight and the link is narrow: on
///   average it carries less than a quarter of the difference between floors and ceilings. An image gets at least the
///   bytes of a thumbnail, or those of its new part without loss if these are fewer.
/// - The region is lossless if the index is among the highest lossless_share and the link carries the ceilings.
/// With a larger index, area or budget the bytes never become fewer.
[[nodiscard]] BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, const PlannedKeyframe& keyframe);

/// Bytes that the link carries in the mean per keyframe, for keyframes at intervals of `interval_s`; 0 if the interval
/// is not positive (not known).
[[nodiscard]] double link_budget_bytes(const MissionParameters& mission, double interval_s);

}  // namespace ilp
