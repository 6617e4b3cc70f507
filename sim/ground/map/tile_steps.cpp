#include "sim/ground/map/tile_steps.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/host/digest.hpp"

namespace ilp::map {
namespace {

using Gains = std::map<std::int64_t, double>;

/// Rounded to what nobody sees, so that a late keyframe changes few tiles far from it.
Gains gains_of(const MapTotals& totals) {
  if (totals.pieces.size() < 2) return {};
  constexpr double steps = 1024;
  Gains gains = balance_exposures(totals.ratios, totals.pieces);
  for (auto& [id, gain] : gains) gain = std::exp(std::round(steps * std::log(gain)) / steps);
  return gains;
}

std::vector<double> gains_for(const std::vector<std::int64_t>& keyframes, const Gains& gains) {
  std::vector<double> values;
  for (const std::int64_t id : keyframes) {
    const auto gain = gains.find(id);
    values.push_back(gain == gains.end() ? 1 : gain->second);
  }
  return values;
}

std::uint64_t finish_digest(std::uint64_t painted, const std::vector<double>& gains) {
  return host::digest({reinterpret_cast<const char*>(gains.data()), gains.size() * sizeof(double)},
                      host::digest("finished 1 " + host::digest_text(painted)));
}

}  // namespace

std::optional<TileSummary> known_summary(std::int64_t strip_id, const TilePlan& tile, intake::TileCache& cache) {
  const auto bytes = cache.summary({strip_id, tile.place}, tile.digest);
  return bytes ? summary_from(*bytes) : std::nullopt;
}

SurfaceTile paint(const TilePlan& tile, double cell, PieceCache& pieces) {
  thread_local PixelRays rays;
  std::vector<TilePiece> painted;
  for (const std::int64_t id : tile.keyframes) painted.push_back({id, pieces.piece(id, rays)});
  return paint_tile(tile.place, cell, painted);
}

void MapTotals::take(TileSummary& summary) {
  for (std::size_t i = 0; i < summary.keyframes.size(); ++i) {
    if (summary.shown[i].cells == 0) continue;
    ShownPiece& piece = pieces[summary.keyframes[i]];
    piece.cells += summary.shown[i].cells;
    piece.grey += summary.shown[i].grey;
  }
  for (const auto& [pair, samples] : summary.ratios) ratios[pair].add(samples);
  for (const auto& [step_class, number] : summary.steps) steps[step_class] += number;
  summary.ratios = {};
  summary.steps = {};
  summary.shown = {};
}

std::vector<TileFinish> plan_finish(const MapPlan& plan, const std::vector<TileSummary>& summaries,
                                    const MapTotals& totals) {
  const Gains gains = gains_of(totals);
  std::vector<TileFinish> tiles;
  for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
    if (summaries[i].empty()) continue;
    const TilePlan& painted = plan.tiles[i];
    TileFinish& tile = tiles.emplace_back();
    tile.place = painted.place;
    tile.painted = painted.digest;
    tile.keyframes = summaries[i].keyframes;
    tile.gains = gains_for(tile.keyframes, gains);
    tile.digest = finish_digest(tile.painted, tile.gains);
  }
  return tiles;
}

std::vector<std::uint8_t> finished_summary() {
  return {1};
}

std::vector<std::uint8_t> finished_cells(std::span<const std::uint8_t> painted, const TileFinish& tile, double cell) {
  const std::optional<MapTile> cells = cells_from(painted, painted_side_cells);
  if (!cells) throw DamagedCatalogue("a tile of the map cannot be read back");
  for (const std::uint16_t s : cells->source.samples) {
    if (s > tile.gains.size()) throw DamagedCatalogue("a tile names no keyframe");
  }
  return bytes_of(finish_tile(*cells, tile.gains, cell));
}

}  // namespace ilp::map
