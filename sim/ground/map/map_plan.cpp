#include "sim/ground/map/map_plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/ground/map/surface_tile.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::map {
namespace {

// A map beyond this is an error of poses, not a flight.
constexpr double max_map_side = 200000, max_map_tiles = 100000, usual_tiles_of_a_view = 100;

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
  return tiles < std::max(max_map_tiles, usual_tiles_of_a_view * static_cast<double>(views.size())) &&
         static_cast<double>(all.right - all.left) < most && static_cast<double>(all.bottom - all.top) < most;
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
  std::string text = "tile 6 " + std::to_string(tile.place.column) + " " + std::to_string(tile.place.row) + " ";
  text.append(reinterpret_cast<const char*>(&cell), sizeof(cell));
  for (const std::int64_t id : tile.keyframes) {
    text += " " + std::to_string(id) + " " + host::digest_text(views.at(id).digest);
  }
  return host::digest(text);
}

}  // namespace

KeyframeView view_of(const KeyframeQuickLook& quick_look) {
  return {quick_look.digest, quick_look.ground_step, quick_look.bounds};
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

}  // namespace ilp::map
