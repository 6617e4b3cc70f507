// The two steps of a tile, each a function of what it is given, so that any process may do it: painting needs the
// keyframes under the tile, and finishing the painted cells and the balance that the whole map gives its keyframes.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/map/surface_tile.hpp"

namespace ilp::map {

/// None when the cache has not painted the tile with these inputs.
[[nodiscard]] std::optional<TileSummary> known_summary(std::int64_t strip_id, const TilePlan& tile,
                                                       intake::TileCache& cache);

[[nodiscard]] SurfaceTile paint(const TilePlan& tile, double cell, PatchCache& patches);

struct TileFinish {
  intake::TilePlace place;
  std::uint64_t painted = 0;            ///< digest of the painted tile
  std::uint64_t digest = 0;             ///< of all that the finished tile depends on
  std::vector<std::int64_t> keyframes;  ///< ids, by source - 1
  std::vector<Balance> balance;         ///< by source - 1
};

/// What the whole map needs of its tiles. The order in which tiles are taken makes no difference.
struct MapTotals {
  std::vector<SeamLevels> seam_levels;
  std::map<std::int64_t, ShownPatch> patches;   ///< by keyframe
  std::map<std::int32_t, std::uint64_t> steps;  ///< of TileSummary
  /// The summary loses its seams and steps, which take most of its memory.
  void take(TileSummary& summary);
};

/// By keyframe; none in a map of one patch, which is shown as it is.
[[nodiscard]] std::map<std::int64_t, Balance> map_balance(const MapTotals& totals);

/// The tiles that are not empty, in the order of the plan; `summaries` are in its order too.
[[nodiscard]] std::vector<TileFinish> plan_finish(const MapPlan& plan, const std::vector<TileSummary>& summaries,
                                                  const std::map<std::int64_t, Balance>& balance);

/// What a cache keeps as the summary of a finished tile, which has none.
[[nodiscard]] std::vector<std::uint8_t> finished_summary();
/// From the bytes of the painted cells. Throws std::runtime_error when they are damaged.
[[nodiscard]] std::vector<std::uint8_t> finished_cells(std::span<const std::uint8_t> painted, const TileFinish& tile,
                                                       double cell);

}  // namespace ilp::map
