#include "fsw/localisation/map_canvas.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t whole = 128;  // weight of a pixel along each axis

/// Where a pixel's side lies among the cells: `share` of it in cell `first`, the rest in the next one.
struct Split {
  std::int32_t first = 0;
  std::uint32_t share = 0;
};
using Splits = std::array<Split, map_tile_side>;

/// Pixels of `step` cells from `begin` on.
void split(double begin, double step, Splits& splits) {
  for (std::size_t i = 0; i < splits.size(); ++i) {
    const double from = begin + static_cast<double>(i) * step;
    const double first = std::floor(from);
    const double inside = std::min((first + 1 - from) / step, 1.0);
    splits[i] = {static_cast<std::int32_t>(std::clamp(first, -2.0e9, 2.0e9)),
                 static_cast<std::uint32_t>(std::floor(inside * whole + 0.5))};
  }
}

std::size_t cell_at(const MapPlan& plan, std::int32_t column, std::int32_t row) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(plan.width) + static_cast<std::size_t>(column);
}

double tile_x0(const MapTile& tile, const MapLayer& layer) {
  return layer.x0_m + layer.pixel_m * map_tile_side * tile.column;
}
double tile_y0(const MapTile& tile, const MapLayer& layer) {
  return layer.y0_m - layer.pixel_m * map_tile_side * tile.row;
}

void paint_image(const MapTile& tile, const MapLayer& layer, const MapPlan& plan, MapCanvas& canvas) {
  Splits columns, rows;
  const double step = layer.pixel_m / plan.pixel_m;
  split((tile_x0(tile, layer) - plan.x0_m()) / plan.pixel_m, step, columns);
  split((plan.y0_m() - tile_y0(tile, layer)) / plan.pixel_m, step, rows);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].first < -1 || rows[r].first >= plan.height) continue;
    const std::uint8_t* const line = &tile.image[r * map_tile_side];
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (line[c] == 0 || columns[c].first < -1 || columns[c].first >= plan.width) continue;
      for (int k = 0; k < 4; ++k) {
        const std::int32_t column = columns[c].first + (k & 1), row = rows[r].first + (k >> 1);
        const std::uint32_t wide = (k & 1) == 0 ? columns[c].share : whole - columns[c].share;
        const std::uint32_t high = (k >> 1) == 0 ? rows[r].share : whole - rows[r].share;
        if (wide * high == 0 || column < 0 || row < 0 || column >= plan.width || row >= plan.height) continue;
        canvas.sum[cell_at(plan, column, row)] += wide * high * line[c];
        canvas.weight[cell_at(plan, column, row)] += wide * high;
      }
    }
  }
}

/// False where a post is not known. `u`, `v`: in posts, inside the tile.
bool height_between(const MapTile& tile, double u, double v, double& height_m) {
  const std::int32_t i = std::clamp(static_cast<std::int32_t>(u), 0, map_tile_posts - 2);
  const std::int32_t j = std::clamp(static_cast<std::int32_t>(v), 0, map_tile_posts - 2);
  if (!tile.is_known(i, j) || !tile.is_known(i + 1, j) || !tile.is_known(i, j + 1) || !tile.is_known(i + 1, j + 1))
    return false;
  const double a = u - i, b = v - j;
  height_m = (1 - b) * ((1 - a) * tile.height_m(i, j) + a * tile.height_m(i + 1, j)) +
             b * ((1 - a) * tile.height_m(i, j + 1) + a * tile.height_m(i + 1, j + 1));
  return true;
}

void paint_heights(const MapTile& tile, const MapLayer& layer, const MapPlan& plan, MapCanvas& canvas) {
  const double post_m = layer.pixel_m * map_post_spacing;
  const double x0 = tile_x0(tile, layer), y0 = tile_y0(tile, layer);
  constexpr double last = map_tile_posts - 1;
  for (std::int32_t row = 0; row < plan.height; ++row) {
    const double v = (y0 - (plan.y0_m() - (row + 0.5) * plan.pixel_m)) / post_m;
    if (!(v >= 0 && v < last)) continue;
    for (std::int32_t column = 0; column < plan.width; ++column) {
      const double u = (plan.x0_m() + (column + 0.5) * plan.pixel_m - x0) / post_m;
      double height = 0;
      if (!(u >= 0 && u < last) || !height_between(tile, u, v, height)) continue;
      canvas.height_m[cell_at(plan, column, row)] = static_cast<float>(height);
      canvas.known[cell_at(plan, column, row)] = 1;
    }
  }
}

/// Of a coordinate, in tiles, within those of the layer.
std::int32_t tile_index(double tiles, std::int32_t count) {
  return static_cast<std::int32_t>(std::floor(std::clamp(tiles, -1.0, static_cast<double>(count))));
}

}  // namespace

MapTileRange tiles_under(const MapPlan& plan, const MapLayer& layer) {
  const double side = layer.pixel_m * map_tile_side;
  if (!(side > 0)) return {};
  const double left = (plan.x0_m() - layer.x0_m) / side, top = (layer.y0_m - plan.y0_m()) / side;
  const double wide = plan.width * plan.pixel_m / side, high = plan.height * plan.pixel_m / side;
  return {std::max(tile_index(top, layer.rows), 0), std::min(tile_index(top + high, layer.rows), layer.rows - 1),
          std::max(tile_index(left, layer.columns), 0),
          std::min(tile_index(left + wide, layer.columns), layer.columns - 1)};
}

void begin_canvas(const MapPlan& plan, MapCanvas& canvas) {
  const std::size_t cells = cell_at(plan, 0, plan.height);
  std::fill_n(canvas.sum.begin(), cells, 0U);
  std::fill_n(canvas.weight.begin(), cells, 0U);
  std::fill_n(canvas.height_m.begin(), cells, 0.0F);
  std::fill_n(canvas.known.begin(), cells, std::uint8_t{0});
}

Status paint_tile(const MapTile& tile, const MapLayer& layer, const MapPlan& plan, MapCanvas& canvas) {
  const double ratio = plan.pixel_m / layer.pixel_m;
  if (!(ratio > 1 - 1e-9 && ratio < most_canvas_ratio)) return out_of_range(Argument::map_window, ratio);
  paint_image(tile, layer, plan, canvas);
  paint_heights(tile, layer, plan, canvas);
  return {};
}

void finish_canvas(const MapPlan& plan, const MapLayer& layer, MapCanvas& canvas) {
  const double ratio = plan.pixel_m / layer.pixel_m;
  const double least = 0.5 * ratio * ratio * whole * whole;
  const std::size_t cells = cell_at(plan, 0, plan.height);
  for (std::size_t i = 0; i < cells; ++i) {
    const std::uint32_t weight = canvas.weight[i];
    const bool known = static_cast<double>(weight) > least;
    const std::uint32_t mean = known ? (canvas.sum[i] + weight / 2) / weight : 0;
    canvas.image[i] = static_cast<std::uint8_t>(known ? std::clamp<std::uint32_t>(mean, 1, 255) : 0);
  }
}

MapWindow window_of(const MapPlan& plan, const MapDirectory& directory, const MapCanvas& canvas) {
  MapWindow window;
  window.width = plan.width;
  window.height = plan.height;
  window.pixel_m = plan.pixel_m;
  window.x0_m = plan.x0_m();
  window.y0_m = plan.y0_m();
  window.image = canvas.image.data();
  window.height_m = canvas.height_m.data();
  window.known = canvas.known.data();
  window.image_is_flat = directory.light == MapLight::flat;
  window.sun_azimuth_rad = directory.sun_azimuth_rad;
  window.sun_elevation_rad = directory.sun_elevation_rad;
  return window;
}

bool tile_height(const MapTile& tile, const MapLayer& layer, double x_m, double y_m, double& height_m) {
  const double post_m = layer.pixel_m * map_post_spacing;
  const double u = (x_m - tile_x0(tile, layer)) / post_m, v = (tile_y0(tile, layer) - y_m) / post_m;
  constexpr double last = map_tile_posts - 1;
  if (!(u >= 0 && u <= last && v >= 0 && v <= last)) return false;
  if (height_between(tile, u, v, height_m)) return true;
  double sum = 0, count = 0;
  for (std::int32_t j = 0; j < map_tile_posts; ++j) {
    for (std::int32_t i = 0; i < map_tile_posts; ++i) {
      if (!tile.is_known(i, j)) continue;
      sum += tile.height_m(i, j);
      ++count;
    }
  }
  if (count > 0) height_m = sum / count;
  return count > 0;
}

}  // namespace ilp
