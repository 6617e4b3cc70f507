// Which tiles the map of a strip has, and what each of them depends on.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "sim/ground/intake/tile_cache.hpp"
#include "sim/ground/map/keyframe_quick_look.hpp"

namespace ilp::map {

struct KeyframeView {
  std::uint64_t digest = 0;
  double ground_step = 0;
  MapBounds bounds;
};
[[nodiscard]] KeyframeView view_of(const KeyframeQuickLook& quick_look);
/// The keyframes that have a surface.
using KeyframeViews = std::map<std::int64_t, KeyframeView>;

struct TilePlan {
  intake::TilePlace place;
  std::vector<std::int64_t> keyframes;  ///< that may touch the tile with its margin, rising
  std::uint64_t digest = 0;             ///< of all that the painted tile depends on
};

struct MapPlan {
  double cell = 0;              ///< strip units
  std::vector<TilePlan> tiles;  ///< along the flight
};

/// No tiles where the keyframes' bounds and steps make no map.
[[nodiscard]] MapPlan plan_map(const KeyframeViews& views);

}  // namespace ilp::map
