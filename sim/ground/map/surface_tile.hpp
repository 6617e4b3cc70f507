// One tile of a strip's map: painted from the patches of the keyframes that touch it, and kept as bytes.
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
/// A painted tile has this many cells more on each side, so that its patches can be blended without its neighbours.
inline constexpr std::int32_t tile_margin_cells = std::max(seam_reach_cells, blend_reach_cells);
inline constexpr std::int32_t painted_side_cells = tile_side_cells + 2 * tile_margin_cells;

struct TilePatch {
  std::int64_t keyframe_id = 0;
  std::shared_ptr<const SurfaceMesh> surface;
  std::shared_ptr<const SurfaceMesh> laid = nullptr;  ///< laid_surface; may be null
};

/// The part of a tile that the whole map needs; it is small, unlike the cells.
struct TileSummary {
  std::vector<std::int64_t> keyframes;          ///< ids, by source - 1
  std::vector<ShownPatch> shown;                ///< of each
  std::uint64_t measured = 0;                   ///< cells with a count
  std::uint64_t seam_cells = 0;                 ///< where two keyframes cover a cell
  std::map<std::int32_t, std::uint32_t> steps;  ///< how much their heights differ there (seam_step)
  Seams seams;
  /// Bounds of the cells with a height, in the tile; empty when right < left.
  std::int32_t left = 0, top = 0, right = -1, bottom = -1;
  [[nodiscard]] bool empty() const { return right < left; }
};

/// Middle of a class of steps, in cells.
[[nodiscard]] double seam_step(std::int32_t step_class);

struct SurfaceTile {
  TileSummary summary;
  MapTile cells;  ///< with the margin; column and row 0; source by summary.keyframes
};

/// Paints the patches in the order given, with rising ids. Seams are closed; exposures are not balanced, and patches
/// not blended yet.
[[nodiscard]] SurfaceTile paint_tile(const intake::TilePlace& place, double cell,
                                     const std::vector<TilePatch>& patches);

/// Balances the grey of each keyframe (by source - 1), blends the patches of a painted tile, laid ground among them,
/// and cuts the margin off.
[[nodiscard]] MapTile finish_tile(const intake::TilePlace& place, const MapTile& painted,
                                  const std::vector<Balance>& balance, double cell);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const TileSummary& summary);
[[nodiscard]] std::vector<std::uint8_t> bytes_of(const MapTile& cells);
/// None when the bytes are not what bytes_of gave.
[[nodiscard]] std::optional<TileSummary> summary_from(std::span<const std::uint8_t> bytes);
/// `side` cells each way.
[[nodiscard]] std::optional<MapTile> cells_from(std::span<const std::uint8_t> bytes, std::int32_t side);

// Caches patches of surface for the tiles that are being painted; a patch is made when it is first needed.

/// Holds the most recently used patches that fit into `bytes`. Several threads may call it at once.
class PatchCache {
 public:
  PatchCache(const intake::Flight& flight, std::size_t bytes) : flight_(flight), budget_(bytes) {}
  [[nodiscard]] TilePatch patch(std::int64_t keyframe_id, PixelRays& rays);

 private:
  [[nodiscard]] std::optional<TilePatch> held(std::int64_t keyframe_id);

  const intake::Flight& flight_;
  std::size_t budget_;
  std::mutex mutex_;
  std::list<TilePatch> entries_;  ///< used last first
  std::size_t held_bytes_ = 0;
};

}  // namespace ilp::map
