#include "fsw/localisation/map_part.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

/// A layer may be so much coarser than the finest useful pixel: it is less to paint.
constexpr double coarser_layer = 1.25;

// Keyframes are registered together while the poses between them err by less, and how much the poses drift.
constexpr double most_apart_px = 0.75, drift_together = 0.015;

}  // namespace

void MapPart::open() {
  work_.usable = false;
  if (wiring_.source == nullptr) return;
  auto& scratch = wiring_.scratch.as<MapFixScratch>();
  std::size_t size = 0;
  work_.directory_mark = wiring_.source->directory_mark();
  Status status = wiring_.source->read_directory(scratch.directory_file, size);
  // A map may come later.
  if (status.is(StatusCode::not_found)) return;
  if (status.ok())
    status =
        parse_map_directory(std::span(scratch.directory_file).first(size), wiring_.source->key(), workspace_.directory);
  if (status.ok() && workspace_.directory.body != wiring_.mission.body)
    status = {StatusCode::map_other_body, static_cast<std::int64_t>(workspace_.directory.body),
              static_cast<std::int64_t>(wiring_.mission.body)};
  work_.usable = status.ok();
  for (MapWorkspace::TileAtHand& at_hand : workspace_.tiles) at_hand.entry = limits::max_map_tiles;
  if (status.ok() || (status.code == work_.refused && status.a == work_.refused_a)) return;
  work_.refused = status.code;
  work_.refused_a = status.a;
  const Status refused = {StatusCode::map_refused, static_cast<std::int64_t>(status.code), status.a};
  work_.updates = status.is(StatusCode::map_other_body) ? status : refused;
}

const MapTile* MapPart::tile(std::size_t entry) {
  if (entry >= workspace_.directory.tiles.size()) return nullptr;
  MapWorkspace::TileAtHand* oldest = &workspace_.tiles[0];
  for (MapWorkspace::TileAtHand& at_hand : workspace_.tiles) {
    if (at_hand.entry == entry) {
      at_hand.used = ++workspace_.uses;
      return &at_hand.tile;
    }
    if (at_hand.used < oldest->used) oldest = &at_hand;
  }
  const MapTileEntry& place = workspace_.directory.tiles[entry];
  auto& scratch = wiring_.scratch.as<MapFixScratch>();
  std::size_t size = 0;
  Status status = wiring_.source->read_tile({place.layer, place.row, place.column}, scratch.file, size);
  // A tile may come later.
  if (status.is(StatusCode::not_found)) return nullptr;
  if (status.ok()) {
    oldest->entry = limits::max_map_tiles;
    status =
        decode_map_tile(std::span(scratch.file).first(size), workspace_.directory, entry, scratch.tile, oldest->tile);
  }
  if (!status.ok()) {
    work_.updates = {StatusCode::map_tile_unusable, static_cast<std::int64_t>(entry),
                     static_cast<std::int64_t>(status.code)};
    return nullptr;
  }
  oldest->entry = entry;
  oldest->used = ++workspace_.uses;
  return &oldest->tile;
}

std::size_t MapPart::entry_at(std::uint32_t layer, double x_m, double y_m) const {
  const MapLayer& grid = workspace_.directory.layers[layer];
  const double side = grid.pixel_m * map_tile_side;
  const double column = std::floor((x_m - grid.x0_m) / side), row = std::floor((grid.y0_m - y_m) / side);
  const bool inside = column >= 0 && column < grid.columns && row >= 0 && row < grid.rows;
  if (!inside) return limits::max_map_tiles;
  const std::size_t entry =
      find_map_tile(workspace_.directory, layer, static_cast<std::int32_t>(row), static_cast<std::int32_t>(column));
  return entry < workspace_.directory.tiles.size() ? entry : limits::max_map_tiles;
}

std::size_t MapPart::coarsest_tile_at(double x_m, double y_m) const {
  const std::uint32_t layers = std::min<std::uint32_t>(workspace_.directory.layer_count, limits::max_map_layers);
  for (std::uint32_t k = layers; k > 0; --k) {
    const std::size_t entry = entry_at(k - 1, x_m, y_m);
    if (entry < limits::max_map_tiles) return entry;
  }
  return limits::max_map_tiles;
}

std::uint32_t MapPart::layer_for(double image_pixel_m, double x_m, double y_m) const {
  const std::uint32_t layers = std::min<std::uint32_t>(workspace_.directory.layer_count, limits::max_map_layers);
  std::uint32_t chosen = layers;
  for (std::uint32_t k = 0; k < layers; ++k) {
    if (entry_at(k, x_m, y_m) >= limits::max_map_tiles) continue;
    const double pixel = workspace_.directory.layers[k].pixel_m;
    if (chosen == layers || pixel <= coarser_layer * least_map_image_pixels * image_pixel_m) chosen = k;
  }
  return chosen == layers ? 0 : chosen;
}

BodyPlace MapPart::origin() const {
  constexpr double deg_per_rad = 180 / pi;
  return {workspace_.directory.longitude_rad * deg_per_rad, workspace_.directory.latitude_rad * deg_per_rad, 0};
}

void MapPart::plan_together(double image_pixels) {
  auto& memory = wiring_.scratch.as<MapFixScratch>();
  memory.together[0] = memory.keyframe;
  work_.together = 1;
  if (work_.relief) return;
  SmallKeyframes& kept = workspace_.after.strip;
  if (!holds_few_patches(memory.keyframe.camera, image_pixels)) {
    kept.clear();
    return;
  }
  keep_small(memory.keyframe, work_.pose, kept);
  const double drift = std::sqrt(work_.scale_sigma * work_.scale_sigma + drift_together * drift_together);
  const double farthest_m = work_.scale > 0 ? most_apart_px * work_.plan.pixel_m / drift : 0;
  work_.together = put_together(memory.keyframe, work_.pose, kept, work_.scale, farthest_m, memory.together);
  for (; work_.together > 1; --work_.together) {
    const Result<MapPlan> planned =
        plan_map_window({memory.together.data(), work_.together}, work_.prior, work_.ground_m, work_.plan.pixel_m);
    const bool fits = planned.ok() && std::max(planned.value().width, planned.value().height) < max_map_window_side &&
                      std::max(planned.value().sheet_width, planned.value().sheet_height) < max_map_sheet_side;
    if (!fits) continue;
    work_.plan = planned.value();
    break;
  }
}

}  // namespace ilp
