// A map whose content follows from formulas.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "fsw/maps/map_directory.hpp"
#include "fsw/maps/map_tile.hpp"

namespace ilp::test {

inline std::unique_ptr<MapDirectory> known_directory() {
  auto directory = std::make_unique<MapDirectory>();
  directory->id = 0x123456789ABCDEF0;
  directory->body = Body::mars;
  directory->light = MapLight::flat;
  directory->longitude_rad = 2.4;
  directory->latitude_rad = -0.08;
  directory->sun_azimuth_rad = 2.2;
  directory->sun_elevation_rad = 0.55;
  directory->ambient = 0.25;
  directory->image_sigma = 2;
  directory->height_sigma_m = 0.75;
  directory->place_sigma_m = 100;
  directory->layer_count = 2;
  directory->layers[0] = {2.5, -1000, 2000, 8, 6};
  directory->layers[1] = {10, -1000, 2000, 2, 2};
  return directory;
}

/// As it is written; signed if there is a key.
inline std::vector<std::uint8_t> bytes_of(const MapDirectory& directory, std::span<const std::uint8_t> key = {}) {
  std::vector<std::uint8_t> bytes(max_map_directory_bytes);
  std::size_t size = 0;
  EXPECT_TRUE(write_map_directory(directory, key, bytes, size).ok());
  bytes.resize(size);
  return bytes;
}

/// Hills and a pattern, with a corner of which nothing is known.
inline std::unique_ptr<MapTile> known_tile() {
  auto tile = std::make_unique<MapTile>();
  tile->layer = 0;
  tile->row = 2;
  tile->column = 3;
  tile->height_step_m = 0.05;
  tile->height_offset_m = -4400;
  for (std::int32_t y = 0; y < map_tile_side; ++y) {
    for (std::int32_t x = 0; x < map_tile_side; ++x) {
      const double grey = 128 + 50 * std::sin(x * 0.21 + y * 0.05) * std::cos(y * 0.17) + (x / 64 + y / 64) % 2 * 20;
      tile->image[static_cast<std::size_t>(y * map_tile_side + x)] =
          x + y < 100 ? std::uint8_t{0} : static_cast<std::uint8_t>(grey);
    }
  }
  for (std::int32_t j = 0; j < map_tile_posts; ++j) {
    for (std::int32_t i = 0; i < map_tile_posts; ++i) {
      const double steps = 3000 * std::sin(i * 0.07) * std::cos(j * 0.09) + (i * j) % 7;
      tile->posts[static_cast<std::size_t>(j * map_tile_posts + i)] =
          i + j < 20 ? unknown_post : static_cast<std::int16_t>(steps);
    }
  }
  return tile;
}

/// The file of a tile, entered into the directory.
inline std::vector<std::uint8_t> enter_tile(const MapTile& tile, const MapTileFeatures& features,
                                            std::size_t image_bytes, MapDirectory& directory) {
  const auto workspace = std::make_unique<MapTileWorkspace>();
  std::vector<std::uint8_t> file(limits::max_map_tile_bytes);
  std::size_t size = 0;
  if (!encode_map_tile(tile, features, directory.id, {image_bytes}, *workspace, file, size).ok()) return {};
  file.resize(size);
  MapTileEntry entry;
  entry.digest = map_tile_digest(directory.id, file);
  entry.bytes = static_cast<std::uint16_t>(size);
  entry.layer = tile.layer;
  entry.row = tile.row;
  entry.column = tile.column;
  static_cast<void>(directory.tiles.push_back(entry));
  return file;
}

}  // namespace ilp::test
