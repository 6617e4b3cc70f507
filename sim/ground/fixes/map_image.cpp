#include "sim/ground/fixes/map_image.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "fsw/maps/map_tile.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::fixes {

struct MapImage::Scratch {
  std::vector<std::uint8_t> file = std::vector<std::uint8_t>(limits::max_map_tile_bytes);
  MapTileWorkspace workspace;
  MapTile tile;
};

void read_map_directory(MapSource& source, const std::filesystem::path& folder, MapDirectory& directory) {
  std::vector<std::uint8_t> bytes(max_map_directory_bytes);
  std::size_t size = 0;
  const Status read = source.read_directory(bytes, size);
  if (read.is(StatusCode::not_found)) {
    throw std::runtime_error(folder.string() + " has no map: " + map_directory_name +
                             " expected, which ilp-ground map-tiles writes");
  }
  host::require(read, "map " + folder.string());
  host::require(parse_map_directory(std::span(bytes).first(size), source.key(), directory), "map " + folder.string());
}

MapImage::MapImage(const std::filesystem::path& folder) : directory_(std::make_unique<MapDirectory>()) {
  host::require(source_.open(folder.c_str()), "map " + folder.string());
  read_map_directory(source_, folder, *directory_);
}

void MapImage::paint(std::size_t entry, double x0_m, double y0_m, double pixel_m, Scratch& scratch,
                     host::Raster<std::uint8_t>& picture) {
  const MapTileEntry& at = directory_->tiles[entry];
  const MapLayer& layer = directory_->layers[at.layer];
  // Picture px of the tile's corner, and of its side.
  const double side = map_tile_side * layer.pixel_m / pixel_m;
  const double left = (layer.x0_m - x0_m) / pixel_m + at.column * side,
               top = (y0_m - layer.y0_m) / pixel_m + at.row * side;
  const bool seen = left < picture.width && top < picture.height && left + side > 0 && top + side > 0;
  if (!seen) return;
  std::size_t size = 0;
  if (!source_.read_tile({at.layer, at.row, at.column}, scratch.file, size).ok()) return;
  if (!decode_map_tile(std::span(scratch.file).first(size), *directory_, entry, scratch.workspace, scratch.tile).ok())
    return;
  const auto first = [](double low) { return static_cast<std::int32_t>(std::ceil(std::max(low - 0.5, 0.0))); };
  const auto end = [](double high, std::int32_t most) {
    return static_cast<std::int32_t>(std::min(std::ceil(high - 0.5), static_cast<double>(most)));
  };
  for (std::int32_t row = first(top); row < end(top + side, picture.height); ++row) {
    for (std::int32_t column = first(left); column < end(left + side, picture.width); ++column) {
      const auto cell = [&](double px) {
        return static_cast<std::size_t>(std::clamp(px / side * map_tile_side, 0.0, map_tile_side - 1.0));
      };
      const std::uint8_t grey = scratch.tile.image[cell(row + 0.5 - top) * map_tile_side + cell(column + 0.5 - left)];
      if (grey != 0) picture.at(column, row) = grey;
    }
  }
}

host::Raster<std::uint8_t> MapImage::picture(double x0_m, double y0_m, double pixel_m, std::int32_t width,
                                             std::int32_t height) {
  host::Raster<std::uint8_t> picture(width, height);
  const auto scratch = std::make_unique<Scratch>();
  // The coarsest layer that is as fine as the picture, else the finest; coarser ones around it.
  std::uint32_t finest = 0;
  for (std::uint32_t k = 0; k < directory_->layer_count; ++k) {
    if (directory_->layers[k].pixel_m <= pixel_m) finest = k;
  }
  for (std::uint32_t k = directory_->layer_count; k > finest; --k) {
    for (std::size_t entry = 0; entry < directory_->tiles.size(); ++entry) {
      if (directory_->tiles[entry].layer == k - 1) paint(entry, x0_m, y0_m, pixel_m, *scratch, picture);
    }
  }
  return picture;
}

}  // namespace ilp::fixes
