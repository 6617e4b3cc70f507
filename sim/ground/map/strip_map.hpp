// The map of a strip, merged tile by tile from the keyframes that touch each tile (decisions.md, 8). Only tiles whose
// keyframes have changed are painted again; the result depends on the received data only, not on its order.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "sim/ground/intake/tile_cache.hpp"
#include "sim/ground/map/ground_grid.hpp"
#include "sim/ground/map/map_plan.hpp"
#include "sim/ground/map/surface_tile.hpp"
#include "sim/ground/map/tile_steps.hpp"

namespace ilp::map {

struct MapStatistics {
  std::size_t tiles = 0, painted = 0;              ///< painted: in this run
  std::uint64_t measured_cells = 0;                ///< that a keyframe's surface covers
  double covered_area = 0;                         ///< square strip units
  std::uint64_t seam_cells = 0;                    ///< where two keyframes cover a cell
  double seam_step_median = 0, seam_step_p95 = 0;  ///< how much their heights differ there, strip units
};

struct StripMap {
  Mosaic mosaic;
  std::uint64_t digest = 0;  ///< of all that the mosaic depends on
  MapStatistics statistics;
  std::map<std::int64_t, Balance> balance;  ///< by keyframe; empty where the pieces are shown as they are
};

/// Called with the tiles done and all tiles, from one thread at a time.
using TileProgress = std::function<void(std::size_t, std::size_t)>;

struct MapParams {
  std::size_t chunk_bytes = std::size_t{96} << 20U;  ///< memory for pieces of surface
  std::size_t threads = 0;                           ///< 0: one per core
};

struct PaintedTiles {
  std::vector<TileSummary> summaries;  ///< in the order of the plan, without what `totals` has
  MapTotals totals;
  std::size_t count = 0;  ///< that the cache did not have
};

/// Brings every painted tile of the plan into the cache.
[[nodiscard]] PaintedTiles paint_tiles(const intake::Flight& flight, std::int64_t strip_id, const MapPlan& plan,
                                       intake::TileCache& cache, const MapParams& params, const TileProgress& progress);

/// Seams are closed (seams.hpp), grey is balanced (balance.hpp), and pieces are blended (blend.hpp). The cell is the
/// median distance of neighbouring pixels on the ground, to the nearest of 20 steps a decade, so that few late
/// keyframes leave it as it is; coarser where the map would get absurdly large. `flight` and `cache` must outlive the
/// mosaic. None when no keyframe of the strip has a surface.
[[nodiscard]] std::optional<StripMap> merge_strip(const intake::Flight& flight, const intake::Strip& strip,
                                                  const KeyframeViews& views, intake::TileCache& cache,
                                                  const MapParams& params, const TileProgress& progress);

struct GridParams {
  std::int32_t max_side = 3000;  ///< cells
  std::int64_t max_cells = 6000000;
};

/// The whole map. Where it would be too large, blocks of n x n cells become one cell with mean height, sigma and
/// brightness, largest count, and first source.
[[nodiscard]] GroundGrid overview(const Mosaic& mosaic, const GridParams& params);

/// Merges and returns the whole map in memory.
[[nodiscard]] std::optional<GroundGrid> build_grid(const intake::Flight& flight, const intake::Strip& strip,
                                                   const GridParams& params);

}  // namespace ilp::map
