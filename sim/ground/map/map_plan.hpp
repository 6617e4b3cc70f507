// Plans the map of a strip: its cell size, its tiles, and what each tile depends on.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "sim/ground/intake/tile_cache.hpp"
#include "sim/ground/map/keyframe_quick_look.hpp"

namespace ilp::map {

/// What the plan needs of a keyframe; members as in KeyframeQuickLook.
struct KeyframeView {
  std::uint64_t digest = 0;
  double ground_step = 0;
  MapBounds bounds;
};
[[nodiscard]] KeyframeView view_of(const KeyframeQuickLook& quick_look);
/// The keyframes that have a surface; key: keyframe id.
using KeyframeViews = std::map<std::int64_t, KeyframeView>;

struct TilePlan {
  intake::TilePlace place;
  std::vector<std::int64_t> keyframes;  ///< ids of keyframes that may touch the tile or its margin, ascending
  std::uint64_t digest = 0;             ///< digest of the painted tile's inputs
};

struct MapPlan {
  double cell = 0;              ///< strip units
  std::vector<TilePlan> tiles;  ///< along the flight
};

/// Has no tiles if the keyframes' bounds and ground steps allow no map.
[[nodiscard]] MapPlan plan_map(const KeyframeViews& views);

}  // namespace ilp::map
