#include "sim/ground/map/strip_map.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/map/surface_tile.hpp"
#include "sim/ground/map/tile_steps.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::map {
namespace {

/// A map of at most this number of tiles has no empty columns or rows at its left and top edges.
constexpr std::size_t most_trimmed_tiles = 64;

constexpr const char* damaged_tile = "a tile of the map cannot be read back";

/// Brings every tile of the plan into the cache; the summaries in the order of the plan.
class Merge {
 public:
  Merge(const intake::Flight& flight, std::int64_t strip_id, intake::TileCache& cache, const MapParams& params)
      : strip_id_(strip_id), cache_(cache), threads_(params.threads), patches_(flight, params.chunk_bytes) {}

  PaintedTiles run(const MapPlan& plan, const TileProgress& progress) {
    PaintedTiles tiles;
    tiles.summaries.resize(plan.tiles.size());
    std::size_t done = 0;
    host::for_each_parallel(
        plan.tiles.size(),
        [&](std::size_t i) {
          tiles.summaries[i] = summary_of(plan.tiles[i], plan.cell);
          const std::lock_guard lock(mutex_);
          tiles.totals.take(tiles.summaries[i]);
          if (progress) progress(++done, plan.tiles.size());
        },
        threads_);
    tiles.count = painted_;
    return tiles;
  }

 private:
  TileSummary summary_of(const TilePlan& tile, double cell) {
    const intake::TileKey key{strip_id_, tile.place};
    if (auto summary = known_summary(strip_id_, tile, cache_)) return *summary;
    SurfaceTile painted = paint(tile, cell, patches_);
    cache_.put(key, tile.digest, bytes_of(painted.summary), bytes_of(painted.cells));
    ++painted_;
    return std::move(painted.summary);
  }

  std::int64_t strip_id_;
  intake::TileCache& cache_;
  std::size_t threads_;
  PatchCache patches_;
  std::mutex mutex_;
  std::atomic<std::size_t> painted_{0};
};

double step_at(const std::map<std::int32_t, std::uint64_t>& steps, std::uint64_t count, double share) {
  std::uint64_t passed = 0;
  for (const auto& [step_class, number] : steps) {
    passed += number;
    if (static_cast<double>(passed) >= share * static_cast<double>(count)) return seam_step(step_class);
  }
  return 0;
}

MapStatistics statistics_of(const PaintedTiles& tiles, double cell) {
  MapStatistics s;
  s.painted = tiles.count;
  for (const TileSummary& tile : tiles.summaries) {
    s.tiles += tile.empty() ? 0U : 1U;
    s.measured_cells += tile.measured;
    s.seam_cells += tile.seam_cells;
  }
  s.covered_area = static_cast<double>(s.measured_cells) * cell * cell;
  s.seam_step_median = cell * step_at(tiles.totals.steps, s.seam_cells, 0.5);
  s.seam_step_p95 = cell * step_at(tiles.totals.steps, s.seam_cells, 0.95);
  return s;
}

/// Brings the finished tiles into the cache.
void finish_tiles(std::int64_t strip_id, double cell, const std::vector<TileFinish>& tiles, intake::TileCache& cache,
                  std::size_t threads) {
  host::for_each_parallel(
      tiles.size(),
      [&](std::size_t i) {
        const TileFinish& tile = tiles[i];
        const intake::TileKey key{strip_id, tile.place, intake::TileStage::finished};
        if (cache.summary(key, tile.digest)) return;
        const auto painted = cache.cells({strip_id, tile.place}, tile.painted);
        if (!painted) throw DamagedCatalogue(damaged_tile);
        cache.put(key, tile.digest, finished_summary(), finished_cells(*painted, tile, cell));
      },
      threads);
}

struct CellBox {
  std::int64_t left = 0, top = 0, right = -1, bottom = -1;  ///< columns and rows of the world
};

/// The tiles of a finished map, as their writers read them.
class TileReader {
 public:
  TileReader(const intake::Strip& strip, const MapPlan& plan, const std::vector<TileSummary>& summaries,
             const std::vector<TileFinish>& finished, intake::TileCache& cache)
      : strip_id_(strip.id), cache_(&cache) {
    for (std::size_t i = 0; i < strip.keyframes.size(); ++i) {
      places_[strip.keyframes[i]] = static_cast<std::uint16_t>(i + 1);
    }
    for (const TileFinish& tile : finished) tiles_[tile.place] = {tile.digest, tile.keyframes};
    bool first = true;
    for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
      if (summaries[i].empty()) continue;
      extend(plan.tiles[i].place, summaries[i], first);
      first = false;
    }
    // A map of many tiles begins at the corner of a tile: a later keyframe shifts no block of its files.
    if (tiles_.size() <= most_trimmed_tiles) return;
    box_.left = tile_of(box_.left) * tile_side_cells;
    box_.top = tile_of(box_.top) * tile_side_cells;
  }

  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  [[nodiscard]] const CellBox& box() const { return box_; }
  [[nodiscard]] static std::int64_t tile_of(std::int64_t cell) {
    return static_cast<std::int64_t>(std::floor(static_cast<double>(cell) / tile_side_cells));
  }

  /// Of all that read() gives.
  [[nodiscard]] std::optional<std::uint64_t> digest(std::int64_t column, std::int64_t row) const {
    const intake::TilePlace place{static_cast<std::int32_t>(column), static_cast<std::int32_t>(row)};
    const auto found = tiles_.find(place);
    if (found == tiles_.end()) return std::nullopt;
    intake::InputDigest digest("tile of a map 1");
    digest.add_value(found->second.digest);
    for (const std::int64_t id : found->second.keyframes) digest.add_value(places_.at(id));
    const Cut part = cut_of(place);
    return digest.add_value(part.left).add_value(part.top).add_value(part.width).add_value(part.height).value();
  }

  [[nodiscard]] std::optional<MapTile> read(std::int64_t column, std::int64_t row) const {
    const intake::TilePlace place{static_cast<std::int32_t>(column), static_cast<std::int32_t>(row)};
    const auto found = tiles_.find(place);
    if (found == tiles_.end()) return std::nullopt;
    const auto bytes = cache_->cells({strip_id_, place, intake::TileStage::finished}, found->second.digest);
    auto tile = bytes ? cells_from(*bytes, tile_side_cells) : std::nullopt;
    if (!tile) throw DamagedCatalogue(damaged_tile);
    const std::vector<std::int64_t>& keyframes = found->second.keyframes;
    for (std::uint16_t& s : tile->source.samples) {
      if (s > keyframes.size()) throw DamagedCatalogue("a tile names no keyframe");
      if (s > 0) s = places_.at(keyframes[s - 1U]);
    }
    return cut(place, *tile);
  }

 private:
  struct Tile {
    std::uint64_t digest = 0;
    std::vector<std::int64_t> keyframes;
  };

  void extend(const intake::TilePlace& place, const TileSummary& s, bool first) {
    const std::int64_t x = std::int64_t{place.column} * tile_side_cells, y = std::int64_t{place.row} * tile_side_cells;
    const CellBox own{x + s.left, y + s.top, x + s.right, y + s.bottom};
    box_ = first ? own
                 : CellBox{std::min(box_.left, own.left), std::min(box_.top, own.top), std::max(box_.right, own.right),
                           std::max(box_.bottom, own.bottom)};
  }

  /// What of a tile lies in the box.
  struct Cut {
    std::int32_t left = 0, top = 0, width = 0, height = 0;
  };
  [[nodiscard]] Cut cut_of(const intake::TilePlace& place) const {
    const std::int64_t x = std::int64_t{place.column} * tile_side_cells, y = std::int64_t{place.row} * tile_side_cells;
    const auto left = static_cast<std::int32_t>(std::max(box_.left - x, std::int64_t{0}));
    const auto top = static_cast<std::int32_t>(std::max(box_.top - y, std::int64_t{0}));
    const auto width = static_cast<std::int32_t>(std::min(box_.right - x + 1, std::int64_t{tile_side_cells})) - left;
    const auto height = static_cast<std::int32_t>(std::min(box_.bottom - y + 1, std::int64_t{tile_side_cells})) - top;
    return {left, top, width, height};
  }

  [[nodiscard]] MapTile cut(const intake::TilePlace& place, const MapTile& whole) const {
    const std::int64_t x = std::int64_t{place.column} * tile_side_cells, y = std::int64_t{place.row} * tile_side_cells;
    const auto [left, top, width, height] = cut_of(place);
    MapTile tile;
    tile.column = static_cast<std::int32_t>(x + left - box_.left);
    tile.row = static_cast<std::int32_t>(y + top - box_.top);
    tile.height = host::part_of(whole.height, left, top, width, height);
    tile.sigma = host::part_of(whole.sigma, left, top, width, height);
    tile.ortho = host::part_of(whole.ortho, left, top, width, height);
    tile.count = host::part_of(whole.count, left, top, width, height);
    tile.source = host::part_of(whole.source, left, top, width, height);
    tile.laid.height = host::part_of(whole.laid.height, left, top, width, height);
    tile.laid.grey = host::part_of(whole.laid.grey, left, top, width, height);
    return tile;
  }

  std::int64_t strip_id_;
  intake::TileCache* cache_;
  std::map<std::int64_t, std::uint16_t> places_;
  std::map<intake::TilePlace, Tile> tiles_;
  CellBox box_;
};

Mosaic mosaic_of(std::shared_ptr<const TileReader> tiles, double cell) {
  const CellBox& box = tiles->box();
  const std::int64_t first_column = TileReader::tile_of(box.left), first_row = TileReader::tile_of(box.top);
  Mosaic mosaic;
  mosaic.geometry = {static_cast<double>(box.left) * cell, -static_cast<double>(box.top) * cell, cell,
                     static_cast<std::int32_t>(box.right - box.left + 1),
                     static_cast<std::int32_t>(box.bottom - box.top + 1)};
  mosaic.tile_columns = static_cast<std::int32_t>(TileReader::tile_of(box.right) - first_column + 1);
  mosaic.tile_rows = static_cast<std::int32_t>(TileReader::tile_of(box.bottom) - first_row + 1);
  mosaic.tile_side = tile_side_cells;
  mosaic.left = static_cast<std::int32_t>(first_column * tile_side_cells - box.left);
  mosaic.top = static_cast<std::int32_t>(first_row * tile_side_cells - box.top);
  mosaic.digest = [tiles, first_column, first_row](std::int32_t column, std::int32_t row) {
    return tiles->digest(first_column + column, first_row + row);
  };
  mosaic.tile = [tiles = std::move(tiles), first_column, first_row](std::int32_t column, std::int32_t row) {
    return tiles->read(first_column + column, first_row + row);
  };
  return mosaic;
}

std::int32_t stride_of(const MapGeometry& map, const GridParams& params) {
  std::int32_t stride = 1;
  const auto blocks = [&](std::int32_t cells) { return std::int64_t{(cells + stride - 1) / stride}; };
  while (std::max(blocks(map.columns), blocks(map.rows)) > params.max_side ||
         blocks(map.columns) * blocks(map.rows) > params.max_cells) {
    ++stride;
  }
  return stride;
}

/// Sums over the cells of blocks.
class BlockSums {
 public:
  BlockSums(GroundGrid& grid, std::int32_t stride)
      : grid_(grid), stride_(stride), sums_(grid.height.samples.size()), laid_(grid.height.samples.size()) {}

  void add(const MapTile& tile) {
    for (std::int32_t y = 0; y < tile.height.height; ++y) {
      for (std::int32_t x = 0; x < tile.height.width; ++x) {
        const std::size_t i = tile.height.index(x, y);
        if (tile.source.samples[i] == 0) {
          add_laid(tile, i, grid_.height.index((tile.column + x) / stride_, (tile.row + y) / stride_));
          continue;
        }
        const std::size_t block = grid_.height.index((tile.column + x) / stride_, (tile.row + y) / stride_);
        Sums& sums = sums_[block];
        sums.height += tile.height.samples[i];
        sums.grey += tile.ortho.samples[i];
        ++sums.cells;
        if (std::isfinite(tile.sigma.samples[i])) {
          sums.sigma += tile.sigma.samples[i];
          ++sums.sigmas;
        }
        grid_.count.samples[block] = std::max(grid_.count.samples[block], tile.count.samples[i]);
        if (grid_.source.samples[block] == 0) grid_.source.samples[block] = tile.source.samples[i];
      }
    }
  }

  void finish() {
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const Sums& sums = sums_[i];
      if (sums.cells == 0) continue;
      grid_.height.samples[i] = static_cast<float>(sums.height / sums.cells);
      grid_.ortho.samples[i] = static_cast<std::uint8_t>((sums.grey + sums.cells / 2) / sums.cells);
      if (sums.sigmas > 0) grid_.sigma.samples[i] = static_cast<float>(sums.sigma / sums.sigmas);
    }
    finish_laid();
  }

 private:
  struct Sums {
    double height = 0, sigma = 0;
    std::uint32_t grey = 0, cells = 0, sigmas = 0;
  };
  struct LaidSums {
    float height = 0;
    std::uint32_t grey = 0, cells = 0;
  };

  void add_laid(const MapTile& tile, std::size_t i, std::size_t block) {
    if (tile.laid.grey.empty() || tile.laid.grey.samples[i] == 0) return;
    laid_[block].height += tile.laid.height.samples[i];
    laid_[block].grey += tile.laid.grey.samples[i];
    ++laid_[block].cells;
  }

  /// A block with any measured cell is measured.
  void finish_laid() {
    grid_.laid.height =
        host::Raster<float>(grid_.height.width, grid_.height.height, std::numeric_limits<float>::quiet_NaN());
    grid_.laid.grey = host::Raster<std::uint8_t>(grid_.height.width, grid_.height.height);
    for (std::size_t i = 0; i < laid_.size(); ++i) {
      const LaidSums& sums = laid_[i];
      if (sums.cells == 0 || sums_[i].cells > 0) continue;
      grid_.laid.height.samples[i] = sums.height / static_cast<float>(sums.cells);
      grid_.laid.grey.samples[i] = static_cast<std::uint8_t>((sums.grey + sums.cells / 2) / sums.cells);
    }
  }

  GroundGrid& grid_;
  std::int32_t stride_;
  std::vector<Sums> sums_;
  std::vector<LaidSums> laid_;
};

std::uint64_t digest_of(const intake::Strip& strip, const MapPlan& plan, const std::vector<TileFinish>& finished,
                        const HeightErrors& errors) {
  std::string text = "map 2 " + host::digest_text(errors.digest()) + " " + std::to_string(strip.id) + " ";
  text.append(reinterpret_cast<const char*>(&plan.cell), sizeof(plan.cell));
  // Sources are places among them.
  for (const std::int64_t id : strip.keyframes) text += " " + std::to_string(id);
  for (const TileFinish& tile : finished) {
    text += "\n" + std::to_string(tile.place.column) + " " + std::to_string(tile.place.row) + " " +
            host::digest_text(tile.digest);
  }
  return host::digest(text);
}

}  // namespace

PaintedTiles paint_tiles(const intake::Flight& flight, std::int64_t strip_id, const MapPlan& plan,
                         intake::TileCache& cache, const MapParams& params, const TileProgress& progress) {
  return Merge(flight, strip_id, cache, params).run(plan, progress);
}

std::optional<StripMap> merge_strip(const intake::Flight& flight, const intake::Strip& strip,
                                    const KeyframeViews& views, intake::TileCache& cache, const MapParams& params,
                                    const TileProgress& progress) {
  if (views.empty()) return std::nullopt;
  const MapPlan plan = plan_map(views);
  if (plan.tiles.empty()) return std::nullopt;
  const PaintedTiles painted = paint_tiles(flight, strip.id, plan, cache, params, progress);
  std::map<std::int64_t, Balance> balance = map_balance(painted.totals);
  const std::vector<TileFinish> finished = plan_finish(plan, painted.summaries, balance);
  finish_tiles(strip.id, plan.cell, finished, cache, params.threads);
  auto tiles = std::make_shared<const TileReader>(strip, plan, painted.summaries, finished, cache);
  if (tiles->empty()) return std::nullopt;
  StripMap map{mosaic_of(std::move(tiles), plan.cell), 0, statistics_of(painted, plan.cell), std::move(balance)};
  map.mosaic.errors = height_errors_of(flight, strip);
  map.digest = digest_of(strip, plan, finished, map.mosaic.errors);
  return map;
}

GroundGrid overview(const Mosaic& mosaic, const GridParams& params) {
  const MapGeometry& map = mosaic.geometry;
  const std::int32_t stride = stride_of(map, params);
  const double half = 0.5 * (stride - 1) * map.cell;
  GroundGrid grid(map.x0 + half, map.y0 - half, map.cell * stride, (map.columns + stride - 1) / stride,
                  (map.rows + stride - 1) / stride);
  BlockSums sums(grid, stride);
  for (std::int32_t row = 0; row < mosaic.tile_rows; ++row) {
    for (std::int32_t column = 0; column < mosaic.tile_columns; ++column) {
      if (const auto tile = mosaic.tile(column, row)) sums.add(*tile);
    }
  }
  sums.finish();
  grid.whole_sigma = whole_sigma_of(grid, mosaic.errors);
  return grid;
}

std::optional<GroundGrid> build_grid(const intake::Flight& flight, const intake::Strip& strip,
                                     const GridParams& params) {
  KeyframeViews views;
  PixelRays rays;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!has_surface(keyframe)) continue;
    const KeyframeQuickLook quick_look = quick_look_at(keyframe, intake::decode_products(keyframe).rasters, 1, rays);
    if (quick_look.ground_step > 0) views[id] = view_of(quick_look);
  }
  intake::MemoryTileCache cache;
  const auto map = merge_strip(flight, strip, views, cache, {}, {});
  if (!map) return std::nullopt;
  return overview(map->mosaic, params);
}

}  // namespace ilp::map
