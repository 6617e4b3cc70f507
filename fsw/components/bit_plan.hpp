// From the index of a keyframe to the bytes its products may take (paper 4.2; decisions.md, 11).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/records/records.hpp"

namespace ilp {

struct BitPlan {
  ProductScheme scheme = ProductScheme::lossy_region;
  std::uint32_t grant_bytes = 0;  ///< ceiling of the whole file
  double priority = 0;            ///< larger goes first
};

/// Bits per newly seen pixel rise from the mission's floor to its ceiling with the index. Below the mission's bound,
/// and where nothing new was seen, an image is a thumbnail, and no image gets less than that. `pixels` is the size of
/// the image.
[[nodiscard]] BitPlan plan_bits(const MissionParameters& mission, ProductKind kind, double richness,
                                std::uint32_t newly_seen, std::size_t pixels);

}  // namespace ilp
