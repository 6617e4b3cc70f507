#include "sim/ground/map/tile_steps.hpp"

#include <cmath>
#include <map>
#include <stdexcept>

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"

namespace ilp::map {
namespace {

std::vector<Balance> balance_of(const std::vector<std::int64_t>& keyframes,
                                const std::map<std::int64_t, Balance>& balance) {
  std::vector<Balance> values;
  for (const std::int64_t id : keyframes) {
    const auto found = balance.find(id);
    values.push_back(found == balance.end() ? Balance{} : found->second);
  }
  return values;
}

std::uint64_t finish_digest(std::uint64_t painted, const std::vector<Balance>& balance) {
  intake::InputDigest digest("finished 4");
  digest.add_value(painted);
  for (const Balance& one : balance) {
    digest.add_value(one.gain).add_value(one.offset);
    for (const double ramp : one.ramp) digest.add_value(ramp);
    for (const std::int64_t middle : one.middle) digest.add_value(middle);
  }
  return digest.value();
}

}  // namespace

std::optional<TileSummary> known_summary(std::int64_t strip_id, const TilePlan& tile, intake::TileCache& cache) {
  const auto bytes = cache.summary({strip_id, tile.place}, tile.digest);
  return bytes ? summary_from(*bytes) : std::nullopt;
}

SurfaceTile paint(const TilePlan& tile, double cell, PatchCache& patches) {
  thread_local PixelRays rays;
  std::vector<TilePatch> painted;
  for (const std::int64_t id : tile.keyframes) painted.push_back(patches.patch(id, rays));
  return paint_tile(tile.place, cell, painted);
}

void MapTotals::take(TileSummary& summary) {
  for (std::size_t i = 0; i < summary.keyframes.size(); ++i) {
    if (summary.shown[i].cells == 0) continue;
    patches[summary.keyframes[i]].add(summary.shown[i]);
  }
  const std::vector<SeamLevels> own = seam_levels_of(summary.seams);
  seam_levels.insert(seam_levels.end(), own.begin(), own.end());
  for (const auto& [step_class, number] : summary.steps) steps[step_class] += number;
  summary.seams = {};
  summary.steps = {};
  summary.shown = {};
}

/// Rounded to what nobody sees, so that a late keyframe changes few tiles far from it.
std::map<std::int64_t, Balance> map_balance(const MapTotals& totals) {
  if (totals.patches.size() < 2) return {};
  constexpr double gain_steps = 1024, offset_steps = 16;
  std::map<std::int64_t, Balance> balance = balance_patches(totals.seam_levels, totals.patches);
  for (auto& [id, one] : balance) {
    one.gain = std::exp(std::round(gain_steps * std::log(one.gain)) / gain_steps);
    one.offset = std::round(offset_steps * one.offset) / offset_steps;
    for (double& ramp : one.ramp) ramp = std::round(offset_steps * ramp) / offset_steps;
  }
  return balance;
}

std::vector<TileFinish> plan_finish(const MapPlan& plan, const std::vector<TileSummary>& summaries,
                                    const std::map<std::int64_t, Balance>& balance) {
  std::vector<TileFinish> tiles;
  for (std::size_t i = 0; i < plan.tiles.size(); ++i) {
    if (summaries[i].empty()) continue;
    const TilePlan& painted = plan.tiles[i];
    TileFinish& tile = tiles.emplace_back();
    tile.place = painted.place;
    tile.painted = painted.digest;
    tile.keyframes = summaries[i].keyframes;
    tile.balance = balance_of(tile.keyframes, balance);
    tile.digest = finish_digest(tile.painted, tile.balance);
  }
  return tiles;
}

std::vector<std::uint8_t> finished_summary() {
  return {1};
}

std::vector<std::uint8_t> finished_cells(std::span<const std::uint8_t> painted, const TileFinish& tile, double cell) {
  const std::optional<MapTile> cells = cells_from(painted, painted_side_cells);
  if (!cells) throw DamagedCatalogue("a tile of the map cannot be read back");
  for (const auto* sources : {&cells->source, &cells->laid.source}) {
    for (const std::uint16_t s : sources->samples) {
      if (s > tile.balance.size()) throw DamagedCatalogue("a tile names no keyframe");
    }
  }
  return bytes_of(finish_tile(tile.place, *cells, tile.balance, cell));
}

}  // namespace ilp::map
