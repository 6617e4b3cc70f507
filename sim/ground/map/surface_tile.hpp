// Makes one tile of a strip's map from the patches of the keyframes that touch it, and serialises it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "sim/ground/intake/tile_cache.hpp"
#include "sim/ground/map/balance.hpp"
#include "sim/ground/map/blend.hpp"
#include "sim/ground/map/ground_grid.hpp"
#include "sim/ground/map/merge.hpp"
#include "sim/ground/map/seams.hpp"

namespace ilp::map {

inline constexpr std::int32_t tile_side_cells = 256;
/// A painted tile extends by this many cells on each side, so that its patches can be blended without other tiles.
inline constexpr std::int32_t tile_margin_cells = std::max(seam_reach_cells, blend_reach_cells);
inline constexpr std::int32_t painted_side_cells = tile_side_cells + 2 * tile_margin_cells;

/// The surfaces of one keyframe (merge.hpp).
struct TilePatch {
  std::int64_t keyframe_id = 0;
  std::shared_ptr<const SurfaceMesh> surface;
  std::shared_ptr<const SurfaceMesh> laid = nullptr;  ///< laid_surface; may be null
};

/// What the map as a whole needs of a tile; small, unlike the cells.
struct TileSummary {
  std::vector<std::int64_t> keyframes;  ///< ids, index source - 1
  std::vector<ShownPatch> shown;        ///< sums for each keyframe, index source - 1
  std::uint64_t measured = 0;           ///< cells with a count above 0
  std::uint64_t seam_cells = 0;         ///< times that a further keyframe covers a covered cell
  /// Histogram of the height differences between keyframes in these cells; key: class (seam_step).
  std::map<std::int32_t, std::uint32_t> steps;
  Seams seams;
  /// Columns and rows in the tile of the first and last cell with a height; no such cell if right < left.
  std::int32_t left = 0, top = 0, right = -1, bottom = -1;
  [[nodiscard]] bool empty() const { return right < left; }
};

/// The height difference in the middle of a class of TileSummary::steps, in cells.
[[nodiscard]] double seam_step(std::int32_t step_class);

struct SurfaceTile {
  TileSummary summary;
  /// With the margin. column and row are 0; source is 1 + index in summary.keyframes.
  MapTile cells;
};

/// Paints the patches in the order given, which is that of ascending ids, and closes seams. Grey values are not
/// balanced and patches not blended yet; finish_tile does that. `cell`: side of a cell, strip units.
[[nodiscard]] SurfaceTile paint_tile(const intake::TilePlace& place, double cell,
                                     const std::vector<TilePatch>& patches);

/// Balances the grey values of a painted tile, blends its patches, those of laid ground too, and removes the margin.
/// `balance`: of each keyframe, index source - 1.
[[nodiscard]] MapTile finish_tile(const intake::TilePlace& place, const MapTile& painted,
                                  const std::vector<Balance>& balance, double cell);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const TileSummary& summary);
[[nodiscard]] std::vector<std::uint8_t> bytes_of(const MapTile& cells);
/// Reads back what bytes_of wrote; none if the bytes are damaged.
[[nodiscard]] std::optional<TileSummary> summary_from(std::span<const std::uint8_t> bytes);
/// Reads back a tile of `side` x `side` cells; none if the bytes are damaged.
[[nodiscard]] std::optional<MapTile> cells_from(std::span<const std::uint8_t> bytes, std::int32_t side);

// A cache of surface patches for the tiles that are being painted.

/// Makes patches on demand, and holds those most recently used that fit into `bytes`. Several threads may call it at
/// once.
class PatchCache {
 public:
  PatchCache(const intake::Flight& flight, std::size_t bytes) : flight_(flight), budget_(bytes) {}
  [[nodiscard]] TilePatch patch(std::int64_t keyframe_id, PixelRays& rays);

 private:
  [[nodiscard]] std::optional<TilePatch> held(std::int64_t keyframe_id);

  const intake::Flight& flight_;
  std::size_t budget_;
  std::mutex mutex_;
  std::list<TilePatch> entries_;  ///< most recently used first
  std::size_t held_bytes_ = 0;
};

}  // namespace ilp::map
