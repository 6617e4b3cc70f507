// A map of the analytic ground that the keyframes of PlaceFlight show, in memory.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "fsw/maps/map_directory.hpp"
#include "fsw/maps/map_tile.hpp"
#include "fsw/vision/place/place_scratch.hpp"
#include "fsw/vision/terrain/cell_depths.hpp"
#include "tests/support/memory_map_source.hpp"
#include "tests/unit/maps/known_map.hpp"
#include "tests/unit/places/place_flight.hpp"

namespace ilp::test {

/// 2 x 2 tiles about the flight, the sun of the keyframes, no error but that of its coding.
class AnalyticMap {
 public:
  static constexpr double sun_azimuth = 0.4, sun_elevation = 0.7;

  explicit AnalyticMap(Body body = Body::mars, double pixel_m = 1) : pixel(pixel_m) {
    directory_->id = 77;
    directory_->body = body;
    directory_->longitude_rad = 2.4;
    directory_->latitude_rad = 0.3;
    directory_->sun_azimuth_rad = sun_azimuth;
    directory_->sun_elevation_rad = sun_elevation;
    directory_->height_sigma_m = 0.2;
    directory_->place_sigma_m = 30;
    directory_->layer_count = 1;
    directory_->layers[0] = {pixel, west, north, 2, 2};
    for (std::uint16_t row = 0; row < 2; ++row) {
      for (std::uint16_t column = 0; column < 2; ++column) enter(row, column);
    }
    directory_bytes = bytes_of(*directory_);
    for (std::size_t i = 0; i < files.size(); ++i)
      tiles_.push_back({{0, static_cast<std::uint16_t>(i / 2), static_cast<std::uint16_t>(i % 2)}, files[i]});
  }
  /// Of the bytes as they are now.
  [[nodiscard]] MemoryMapSource source() {
    for (std::size_t i = 0; i < files.size(); ++i) tiles_[i].file = files[i];
    return {directory_bytes, tiles_};
  }

  const double pixel, west = -150 * pixel, north = 256 * pixel;  // m
  std::vector<std::uint8_t> directory_bytes;
  std::vector<std::vector<std::uint8_t>> files;

 private:
  [[nodiscard]] double grey(double x, double y) const {
    // The mean of the pixel's area.
    double sum = 0;
    for (int k = 0; k < 9; ++k) {
      const double dx = (k % 3 - 1) * pixel / 3, dy = (k / 3 - 1) * pixel / 3;
      sum += 128 + 2 * (fractal_texture(2 * (x + dx), 2 * (y + dy), 3, 11) - 128);
    }
    return std::clamp(sum / 9, 1.0, 255.0);
  }
  static MapTileFeatures features_of(const MapTile& tile) {
    const auto harris = std::make_unique<HarrisWorkspace>();
    const auto workspace = std::make_unique<PlaceFeatureWorkspace>();
    const auto found = std::make_unique<PlaceFeatures>();
    constexpr std::int32_t side = map_feature_zoom * map_tile_side;
    std::vector<std::uint8_t> enlarged;
    for (std::int32_t y = 0; y < side; ++y) {
      for (std::int32_t x = 0; x < side; ++x) enlarged.push_back(between(tile, x, y));
    }
    const GrayView image{enlarged.data(), side, side};
    if (!find_place_features(image, limits::max_map_features, *harris, *workspace, *found).ok())
      throw std::runtime_error("features");
    MapTileFeatures features;
    for (PlaceFeature feature : *found) {
      feature.x = (feature.x + 0.5F) / map_feature_zoom - 0.5F;
      feature.y = (feature.y + 0.5F) / map_feature_zoom - 0.5F;
      static_cast<void>(features.image.push_back(feature));
    }
    return features;
  }
  /// A pixel of the tile's image enlarged, bilinear.
  static std::uint8_t between(const MapTile& tile, std::int32_t x, std::int32_t y) {
    const double u = std::clamp((x + 0.5) / map_feature_zoom - 0.5, 0.0, map_tile_side - 1.001);
    const double v = std::clamp((y + 0.5) / map_feature_zoom - 0.5, 0.0, map_tile_side - 1.001);
    const auto i = static_cast<std::int32_t>(u), j = static_cast<std::int32_t>(v);
    const auto at = [&](std::int32_t column, std::int32_t row) {
      return static_cast<double>(tile.image[static_cast<std::size_t>(row * map_tile_side + column)]);
    };
    const double above = at(i, j) + (u - i) * (at(i + 1, j) - at(i, j));
    const double below = at(i, j + 1) + (u - i) * (at(i + 1, j + 1) - at(i, j + 1));
    return static_cast<std::uint8_t>(above + (v - j) * (below - above) + 0.5);
  }
  void enter(std::uint16_t row, std::uint16_t column) {
    const auto tile = std::make_unique<MapTile>();
    tile->row = row;
    tile->column = column;
    tile->height_step_m = 0.01;
    const double x0 = west + pixel * map_tile_side * column, y0 = north - pixel * map_tile_side * row;
    for (std::int32_t r = 0; r < map_tile_side; ++r) {
      for (std::int32_t c = 0; c < map_tile_side; ++c) {
        tile->image[static_cast<std::size_t>(r * map_tile_side + c)] =
            static_cast<std::uint8_t>(grey(x0 + (c + 0.5) * pixel, y0 - (r + 0.5) * pixel) + 0.5);
      }
    }
    for (std::int32_t j = 0; j < map_tile_posts; ++j) {
      for (std::int32_t i = 0; i < map_tile_posts; ++i) {
        const double height = PlaceFlight::gentle(x0 + 4 * i * pixel, y0 - 4 * j * pixel);
        tile->posts[static_cast<std::size_t>(j * map_tile_posts + i)] =
            static_cast<std::int16_t>(std::floor(height / tile->height_step_m + 0.5));
      }
    }
    const auto workspace = std::make_unique<MapTileWorkspace>();
    std::vector<std::uint8_t> file(limits::max_map_tile_bytes);
    std::size_t size = 0;
    const MapTileFeatures features = features_of(*tile);
    if (!encode_map_tile(*tile, features, directory_->id, {16384}, *workspace, file, size).ok())
      throw std::runtime_error("tile");
    file.resize(size);
    MapTileEntry entry;
    entry.digest = map_tile_digest(directory_->id, file);
    entry.bytes = static_cast<std::uint16_t>(size);
    entry.row = row;
    entry.column = column;
    static_cast<void>(directory_->tiles.push_back(entry));
    files.push_back(file);
  }

  std::unique_ptr<MapDirectory> directory_ = std::make_unique<MapDirectory>();
  std::vector<MemoryMapSource::Tile> tiles_;
};

}  // namespace ilp::test
