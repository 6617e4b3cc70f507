#include "sim/ground/map/strip_map.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/map/surface_tile.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::map {
namespace {

// A map beyond this is an error of poses, not a flight.
constexpr double max_map_side = 200000, max_map_tiles = 100000;

struct TilePlan {
  intake::TilePlace place;
  std::vector<std::int64_t> keyframes;
  std::uint64_t digest = 0;
};

struct MapPlan {
  double cell = 0;
  std::vector<TilePlan> tiles;  ///< along the flight
};

struct TileRange {
  std::int64_t left = 0, right = 0, top = 0, bottom = 0;
};

TileRange tiles_of(const MapBounds& b, double cell) {
  const double side = tile_side_cells * cell, reach = tile_margin_cells * cell;
  const auto place = [&](double at) { return static_cast<std::int64_t>(std::floor(at / side)); };
  return {place(b.x_low - reach), place(b.x_high + reach), place(-b.y_high - reach), place(-b.y_low + reach)};
}

bool fits(const KeyframeViews& views, double cell) {
  TileRange all{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min(),
                std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
  double tiles = 0;
  for (const auto& [id, view] : views) {
    const TileRange r = tiles_of(view.bounds, cell);
    all = {std::min(all.left, r.left), std::max(all.right, r.right), std::min(all.top, r.top),
           std::max(all.bottom, r.bottom)};
    tiles += static_cast<double>(r.right - r.left + 1) * static_cast<double>(r.bottom - r.top + 1);
  }
  constexpr double most = max_map_side / tile_side_cells;
  return tiles < max_map_tiles && static_cast<double>(all.right - all.left) < most &&
         static_cast<double>(all.bottom - all.top) < most;
}

double choose_cell(const KeyframeViews& views) {
  std::vector<double> steps;
  for (const auto& [id, view] : views) steps.push_back(view.ground_step);
  constexpr double steps_per_decade = 20;
  double cell =
      std::pow(10, std::round(steps_per_decade * std::log10(host::median(std::move(steps)))) / steps_per_decade);
  while (std::isfinite(cell) && !fits(views, cell)) cell *= 2;
  return cell;
}

std::uint64_t digest_of(const TilePlan& tile, double cell, const KeyframeViews& views) {
  std::string text = "tile 2 " + std::to_string(tile.place.column) + " " + std::to_string(tile.place.row) + " ";
  text.append(reinterpret_cast<const char*>(&cell), sizeof(cell));
  for (const std::int64_t id : tile.keyframes) {
    text += " " + std::to_string(id) + " " + host::digest_text(views.at(id).digest);
  }
  return host::digest(text);
}

MapPlan plan_map(const KeyframeViews& views) {
  MapPlan plan;
  plan.cell = choose_cell(views);
  if (!(plan.cell > 0) || !std::isfinite(plan.cell)) return {};
  std::map<intake::TilePlace, std::vector<std::int64_t>> tiles;
  for (const auto& [id, view] : views) {
    const TileRange range = tiles_of(view.bounds, plan.cell);
    for (std::int64_t row = range.top; row <= range.bottom; ++row) {
      for (std::int64_t column = range.left; column <= range.right; ++column) {
        tiles[{static_cast<std::int32_t>(column), static_cast<std::int32_t>(row)}].push_back(id);
      }
    }
  }
  for (auto& [place, keyframes] : tiles) plan.tiles.push_back({place, std::move(keyframes), 0});
  // Neighbouring tiles follow each other as the flight does, so that a piece is made once for all of them.
  std::stable_sort(plan.tiles.begin(), plan.tiles.end(),
                   [](const TilePlan& a, const TilePlan& b) { return a.keyframes.front() < b.keyframes.front(); });
  for (TilePlan& tile : plan.tiles) tile.digest = digest_of(tile, plan.cell, views);
  return plan;
}

/// Brings every tile of the plan into the cache; the summaries in the order of the plan.
class Merge {
 public:
  Merge(const intake::Flight& flight, std::int64_t strip_id, intake::TileCache& cache, const MapParams& params)
      : strip_id_(strip_id), cache_(cache), threads_(params.threads), pieces_(flight, params.piece_bytes) {}

  std::vector<TileSummary> run(const MapPlan& plan, const TileProgress& progress) {
    std::vector<TileSummary> summaries(plan.tiles.size());
    std::size_t done = 0;
    host::for_each_parallel(
        plan.tiles.size(),
        [&](std::size_t i) {
          summaries[i] = summary_of(plan.tiles[i], plan.cell);
          const std::lock_guard lock(mutex_);
          if (progress) progress(++done, plan.tiles.size());
        },
        threads_);
    return summaries;
  }
  [[nodiscard]] std::size_t painted() const { return painted_; }

 private:
  TileSummary summary_of(const TilePlan& tile, double cell) {
    const intake::TileKey key{strip_id_, tile.place};
    if (const auto bytes = cache_.summary(key, tile.digest)) {
      if (auto summary = summary_from(*bytes)) return *summary;
    }
    thread_local PixelRays rays;
    std::vector<TilePiece> pieces;
    for (const std::int64_t id : tile.keyframes) pieces.push_back({id, pieces_.piece(id, rays)});
    SurfaceTile painted = paint_tile(tile.place, cell, pieces);
    cache_.put(key, tile.digest, bytes_of(painted.summary), bytes_of(painted.cells));
    ++painted_;
    return std::move(painted.summary);
  }

  std::int64_t strip_id_;
  intake::TileCache& cache_;
  std::size_t threads_;
  PieceCache pieces_;
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

MapStatistics statistics_of(const std::vector<TileSummary>& summaries, double cell) {
  MapStatistics s;
  std::map<std::int32_t, std::uint64_t> steps;
  for (const TileSummary& tile : summaries) {
    s.tiles += tile.empty() ? 0U : 1U;
    s.measured_cells += tile.measured;
    s.seam_cells += tile.seam_cells;
    for (const auto& [step_class, number] : tile.steps) steps[step_class] += number;
  }
  s.covered_area = static_cast<double>(s.measured_cells) * cell * cell;
  s.seam_step_median = cell * step_at(steps, s.seam_cells, 0.5);
  s.seam_step_p95 = cell * step_at(steps, s.seam_cells, 0.95);
  return s;
}

using Gains = std::map<std::int64_t, double>;

/// Rounded to what nobody sees, so that a late keyframe changes few tiles far from it.
Gains gains_of(const std::vector<TileSummary>& summaries) {
  SeamRatios ratios;
  std::map<std::int64_t, std::uint64_t> cells;
  for (const TileSummary& tile : summaries) {
    for (std::size_t i = 0; i < tile.keyframes.size(); ++i) {
      if (tile.cells[i] > 0) cells[tile.keyframes[i]] += tile.cells[i];
    }
    for (const auto& [pair, samples] : tile.ratios) {
      for (const auto& [step, number] : samples) ratios[pair][step] += number;
    }
  }
  if (cells.size() < 2) return {};
  constexpr double steps = 1024;
  Gains gains = balance_exposures(ratios, cells);
  for (auto& [id, gain] : gains) gain = std::exp(std::round(steps * std::log(gain)) / steps);
  return gains;
}

/// Brings the finished tiles into the cache.
class Finish {
 public:
  Finish(std::int64_t strip_id, double cell, Gains gains, intake::TileCache& cache)
      : strip_id_(strip_id), cell_(cell), gains_(std::move(gains)), cache_(cache) {}

  void run(const MapPlan& plan, const std::vector<TileSummary>& summaries, std::size_t threads) {
    host::for_each_parallel(
        plan.tiles.size(),
        [&](std::size_t i) {
          if (!summaries[i].empty()) finish(plan.tiles[i], summaries[i].keyframes);
        },
        threads);
  }
  [[nodiscard]] std::uint64_t digest_of(std::uint64_t painted, const std::vector<std::int64_t>& keyframes) const {
    const std::vector<double> gains = gains_for(keyframes);
    return host::digest({reinterpret_cast<const char*>(gains.data()), gains.size() * sizeof(double)},
                        host::digest("finished 1 " + host::digest_text(painted)));
  }

 private:
  [[nodiscard]] std::vector<double> gains_for(const std::vector<std::int64_t>& keyframes) const {
    std::vector<double> gains;
    for (const std::int64_t id : keyframes) {
      const auto gain = gains_.find(id);
      gains.push_back(gain == gains_.end() ? 1 : gain->second);
    }
    return gains;
  }

  void finish(const TilePlan& tile, const std::vector<std::int64_t>& keyframes) {
    const std::uint64_t digest = digest_of(tile.digest, keyframes);
    const intake::TileKey key{strip_id_, tile.place, intake::TileStage::finished};
    if (cache_.summary(key, digest)) return;
    const auto bytes = cache_.cells({strip_id_, tile.place}, tile.digest);
    const auto painted = bytes ? cells_from(*bytes, painted_side_cells) : std::nullopt;
    if (!painted) throw std::runtime_error("the catalogue is damaged: a tile of the map cannot be read back");
    for (const std::uint16_t s : painted->source.samples) {
      if (s > keyframes.size()) throw std::runtime_error("the catalogue is damaged: a tile names no keyframe");
    }
    cache_.put(key, digest, {1}, bytes_of(finish_tile(*painted, gains_for(keyframes), cell_)));
  }

  std::int64_t strip_id_;
  double cell_;
  Gains gains_;
  intake::TileCache& cache_;
};

struct CellBox {
  std::int64_t left = 0, top = 0, right = -1, bottom = -1;  ///< columns and rows of the world
};

/// The tiles of a finished map, as their writers read them.
class TileReader {
 public:
  TileReader(const intake::Strip& strip, const MapPlan& plan, const std::vector<TileSummary>& summaries,
             const Finish& finish, intake::TileCache& cache)
      : strip_id_(strip.id), cache_(&cache) {
    for (std::size_t i = 0; i < strip.keyframes.size(); ++i) {
      places_[strip.keyframes[i]] = static_cast<std::uint16_t>(i + 1);
    }
    bool first = true;
    for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
      if (summaries[i].empty()) continue;
      tiles_[plan.tiles[i].place] = {finish.digest_of(plan.tiles[i].digest, summaries[i].keyframes),
                                     summaries[i].keyframes};
      extend(plan.tiles[i].place, summaries[i], first);
      first = false;
    }
  }

  [[nodiscard]] bool empty() const { return tiles_.empty(); }
  [[nodiscard]] const CellBox& box() const { return box_; }
  [[nodiscard]] static std::int64_t tile_of(std::int64_t cell) {
    return static_cast<std::int64_t>(std::floor(static_cast<double>(cell) / tile_side_cells));
  }

  [[nodiscard]] std::optional<MapTile> read(std::int64_t column, std::int64_t row) const {
    const intake::TilePlace place{static_cast<std::int32_t>(column), static_cast<std::int32_t>(row)};
    const auto found = tiles_.find(place);
    if (found == tiles_.end()) return std::nullopt;
    const auto bytes = cache_->cells({strip_id_, place, intake::TileStage::finished}, found->second.digest);
    auto tile = bytes ? cells_from(*bytes, tile_side_cells) : std::nullopt;
    if (!tile) throw std::runtime_error("the catalogue is damaged: a tile of the map cannot be read back");
    const std::vector<std::int64_t>& keyframes = found->second.keyframes;
    for (std::uint16_t& s : tile->source.samples) {
      if (s > keyframes.size()) throw std::runtime_error("the catalogue is damaged: a tile names no keyframe");
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

  /// To what lies in the box.
  [[nodiscard]] MapTile cut(const intake::TilePlace& place, const MapTile& whole) const {
    const std::int64_t x = std::int64_t{place.column} * tile_side_cells, y = std::int64_t{place.row} * tile_side_cells;
    const auto left = static_cast<std::int32_t>(std::max(box_.left - x, std::int64_t{0}));
    const auto top = static_cast<std::int32_t>(std::max(box_.top - y, std::int64_t{0}));
    const auto width = static_cast<std::int32_t>(std::min(box_.right - x + 1, std::int64_t{tile_side_cells})) - left;
    const auto height = static_cast<std::int32_t>(std::min(box_.bottom - y + 1, std::int64_t{tile_side_cells})) - top;
    MapTile tile;
    tile.column = static_cast<std::int32_t>(x + left - box_.left);
    tile.row = static_cast<std::int32_t>(y + top - box_.top);
    tile.height = host::part_of(whole.height, left, top, width, height);
    tile.sigma = host::part_of(whole.sigma, left, top, width, height);
    tile.ortho = host::part_of(whole.ortho, left, top, width, height);
    tile.count = host::part_of(whole.count, left, top, width, height);
    tile.source = host::part_of(whole.source, left, top, width, height);
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
  BlockSums(GroundGrid& grid, std::int32_t stride) : grid_(grid), stride_(stride), sums_(grid.height.samples.size()) {}

  void add(const MapTile& tile) {
    for (std::int32_t y = 0; y < tile.height.height; ++y) {
      for (std::int32_t x = 0; x < tile.height.width; ++x) {
        const std::size_t i = tile.height.index(x, y);
        if (tile.source.samples[i] == 0) continue;
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
  }

 private:
  struct Sums {
    double height = 0, sigma = 0;
    std::uint32_t grey = 0, cells = 0, sigmas = 0;
  };
  GroundGrid& grid_;
  std::int32_t stride_;
  std::vector<Sums> sums_;
};

}  // namespace

KeyframeView view_of(const KeyframeLook& look) {
  return {look.digest, look.ground_step, look.bounds};
}

std::optional<StripMap> merge_strip(const intake::Flight& flight, const intake::Strip& strip,
                                    const KeyframeViews& views, intake::TileCache& cache, const MapParams& params,
                                    const TileProgress& progress) {
  if (views.empty()) return std::nullopt;
  const MapPlan plan = plan_map(views);
  if (plan.tiles.empty()) return std::nullopt;
  Merge merge(flight, strip.id, cache, params);
  const std::vector<TileSummary> summaries = merge.run(plan, progress);
  Finish finish(strip.id, plan.cell, gains_of(summaries), cache);
  finish.run(plan, summaries, params.threads);
  auto tiles = std::make_shared<const TileReader>(strip, plan, summaries, finish, cache);
  if (tiles->empty()) return std::nullopt;
  StripMap map{mosaic_of(std::move(tiles), plan.cell), statistics_of(summaries, plan.cell)};
  map.statistics.painted = merge.painted();
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
  return grid;
}

std::optional<GroundGrid> build_grid(const intake::Flight& flight, const intake::Strip& strip,
                                     const GridParams& params) {
  KeyframeViews views;
  PixelRays rays;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!has_surface(keyframe)) continue;
    const KeyframeLook look = look_at(keyframe, intake::decode_products(keyframe).rasters, 1, rays);
    if (look.ground_step > 0) views[id] = view_of(look);
  }
  intake::MemoryTileCache cache;
  const auto map = merge_strip(flight, strip, views, cache, {}, {});
  if (!map) return std::nullopt;
  return overview(map->mosaic, params);
}

}  // namespace ilp::map
