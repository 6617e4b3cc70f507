// Merges the keyframes of a strip to a map, tile by tile (decisions.md, 8). Only tiles whose keyframes have changed are
// painted again. The result depends on the received data, but not on their order.
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
  std::size_t tiles = 0, painted = 0;  ///< tiles that are not empty; tiles painted in this run, not cached
  std::uint64_t measured_cells = 0;    ///< cells that a keyframe's surface covers
  double covered_area = 0;             ///< area of the measured cells, square strip units
  std::uint64_t seam_cells = 0;        ///< times that a further keyframe covers a covered cell
  /// Median and 95th percentile of the height differences between keyframes in these cells, strip units.
  double seam_step_median = 0, seam_step_p95 = 0;
};

struct StripMap {
  Mosaic mosaic;
  std::uint64_t digest = 0;  ///< digest of the mosaic's inputs
  MapStatistics statistics;
  std::map<std::int64_t, Balance> balance;  ///< key: keyframe id; empty: grey values are not changed
};

/// Called with the number of tiles done and of all tiles, by one thread at a time.
using TileProgress = std::function<void(std::size_t, std::size_t)>;

struct MapParams {
  std::size_t chunk_bytes = std::size_t{96} << 20U;  ///< memory for surface patches
  std::size_t threads = 0;                           ///< 0: one per core
};

struct PaintedTiles {
  std::vector<TileSummary> summaries;  ///< in the order of the plan, without what `totals` took from them
  MapTotals totals;
  std::size_t count = 0;  ///< tiles that were painted now, because the cache did not have them
};

/// Paints the tiles of the plan that the cache does not have, and puts them into it.
[[nodiscard]] PaintedTiles paint_tiles(const intake::Flight& flight, std::int64_t strip_id, const MapPlan& plan,
                                       intake::TileCache& cache, const MapParams& params, const TileProgress& progress);

/// Makes the map of a strip: closes seams (seams.hpp), balances grey values (balance.hpp) and blends patches
/// (blend.hpp). The cell size is the median distance of neighbouring pixels on the ground, rounded to one of 20
/// logarithmic steps per decade, so that a few late keyframes do not change it; it is doubled until the map has a
/// plausible size. `flight` and `cache` must outlive the mosaic. Returns none if no keyframe of the strip has a
/// surface.
[[nodiscard]] std::optional<StripMap> merge_strip(const intake::Flight& flight, const intake::Strip& strip,
                                                  const KeyframeViews& views, intake::TileCache& cache,
                                                  const MapParams& params, const TileProgress& progress);

/// Limits of a grid in memory.
struct GridParams {
  std::int32_t max_side = 3000;      ///< largest number of columns and of rows
  std::int64_t max_cells = 6000000;  ///< largest number of cells
};

/// The whole map as one grid. If the map exceeds the limits, each block of n x n cells becomes one cell with their mean
/// height, sigma and grey value, largest count and first source; n is the smallest that fits.
[[nodiscard]] GroundGrid overview(const Mosaic& mosaic, const GridParams& params);

/// Merges the strip without a lasting cache, and returns the whole map as one grid. Returns none as merge_strip does.
[[nodiscard]] std::optional<GroundGrid> build_grid(const intake::Flight& flight, const intake::Strip& strip,
                                                   const GridParams& params);

}  // namespace ilp::map
