// The two steps that make a tile. Painting needs the keyframes that touch the tile. Finishing needs the painted cells
// and the balance of the keyframes, which depends on the whole map. Each step depends on its arguments only, so that
// any process may do it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/map/surface_tile.hpp"

namespace ilp::map {

/// The summary of a painted tile from the cache; none if the cache has no tile with these inputs.
[[nodiscard]] std::optional<TileSummary> known_summary(std::int64_t strip_id, const TilePlan& tile,
                                                       intake::TileCache& cache);

/// Paints a tile of the plan (paint_tile). `cell`: side of a cell, strip units.
[[nodiscard]] SurfaceTile paint(const TilePlan& tile, double cell, PatchCache& patches);

/// The inputs for finishing a tile.
struct TileFinish {
  intake::TilePlace place;
  std::uint64_t painted = 0;            ///< digest of the painted tile
  std::uint64_t digest = 0;             ///< digest of the finished tile's inputs
  std::vector<std::int64_t> keyframes;  ///< ids, index source - 1
  std::vector<Balance> balance;         ///< balance of each keyframe, index source - 1
};

/// Sums over the summaries of a map's tiles. Their order makes no difference to the map.
struct MapTotals {
  std::vector<SeamLevels> seam_levels;
  std::map<std::int64_t, ShownPatch> patches;   ///< key: keyframe id
  std::map<std::int32_t, std::uint64_t> steps;  ///< sum of TileSummary::steps
  /// Adds a summary. Removes its members `seams`, `steps` and `shown`, which take most of its memory.
  void take(TileSummary& summary);
};

/// The balance of each keyframe; key: keyframe id. Empty for a map of one patch, whose grey values stay.
[[nodiscard]] std::map<std::int64_t, Balance> map_balance(const MapTotals& totals);

/// The inputs for finishing the tiles that are not empty. `summaries` and the result are in the order of the plan.
[[nodiscard]] std::vector<TileFinish> plan_finish(const MapPlan& plan, const std::vector<TileSummary>& summaries,
                                                  const std::map<std::int64_t, Balance>& balance);

/// The placeholder that a cache keeps as summary of a finished tile.
[[nodiscard]] std::vector<std::uint8_t> finished_summary();
/// Finishes a tile: reads the bytes of its painted cells and returns those of the finished cells. `cell`: side of a
/// cell, strip units. Throws DamagedCatalogue if the painted cells are damaged.
[[nodiscard]] std::vector<std::uint8_t> finished_cells(std::span<const std::uint8_t> painted, const TileFinish& tile,
                                                       double cell);

}  // namespace ilp::map
