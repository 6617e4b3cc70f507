#include "sim/ground/maps/map_writer.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <numeric>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "fsw/base/little_endian.hpp"
#include "hal/maps/directory_map_source.hpp"
#include "sim/host/files.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::maps {
namespace fs = std::filesystem;
namespace {

using Bytes = std::vector<std::uint8_t>;

struct MadeTile {
  MapTilePlace place;
  Bytes file;  ///< empty: nothing is known
  std::size_t known_cells = 0, known_posts = 0;
  double rough_as_imaged = 0, rough_flat = 0;
};

std::vector<MadeTile> places_of(const MapDirectory& directory) {
  std::vector<MadeTile> tiles;
  for (std::uint32_t l = 0; l < directory.layer_count; ++l) {
    const MapLayer& layer = directory.layers[l];
    for (std::int32_t row = 0; row < layer.rows; ++row) {
      for (std::int32_t column = 0; column < layer.columns; ++column) {
        MadeTile tile;
        tile.place = {static_cast<std::uint16_t>(l), static_cast<std::uint16_t>(row),
                      static_cast<std::uint16_t>(column)};
        tiles.push_back(std::move(tile));
      }
    }
  }
  return tiles;
}

/// Makes all tiles, in as many threads as there are makers.
void make_tiles(const MapDirectory& directory, const PatchOf& patches, const TileParams& params,
                std::vector<MadeTile>& tiles, std::ostream& messages) {
  const std::size_t threads = std::clamp<std::size_t>(std::thread::hardware_concurrency(), 1, 8);
  std::vector<std::unique_ptr<TileMaker>> makers;
  for (std::size_t i = 0; i < threads; ++i) makers.push_back(std::make_unique<TileMaker>(params));
  std::mutex source, reporting;
  std::atomic<std::size_t> next{0};
  std::size_t done = 0;
  host::Progress progress(messages, "tiles");
  host::for_each_parallel(
      threads,
      [&](std::size_t thread) {
        for (std::size_t k = next++; k < tiles.size(); k = next++) {
          MadeTile& tile = tiles[k];
          const MapLayer& layer = directory.layers[tile.place.layer];
          MapPatch patch;
          {
            const std::lock_guard lock(source);
            patch = patches(layer, area_of_tile(tile.place.row, tile.place.column));
          }
          const TileMaker::Made made = makers[thread]->make(layer, tile.place, std::move(patch));
          tile.file = made.file;
          tile.known_cells = made.known_cells;
          tile.known_posts = made.known_posts;
          tile.rough_as_imaged = made.rough_as_imaged;
          tile.rough_flat = made.rough_flat;
          const std::lock_guard lock(reporting);
          progress(++done, tiles.size());
        }
      },
      threads);
}

/// The same ground in the same tiles is the same map.
std::uint64_t id_of(const MapDirectory& directory, const std::vector<MadeTile>& tiles) {
  Bytes facts;
  const auto add = [&](std::uint64_t value) {
    std::array<std::uint8_t, sizeof(value)> octets{};
    store_little_endian(value, octets.data());
    facts.insert(facts.end(), octets.begin(), octets.end());
  };
  for (const double value : {directory.longitude_rad, directory.latitude_rad, directory.sun_azimuth_rad,
                             directory.sun_elevation_rad, directory.place_sigma_m, directory.height_sigma_m}) {
    add(std::bit_cast<std::uint64_t>(value));
  }
  for (std::uint32_t l = 0; l < directory.layer_count; ++l) {
    add(std::bit_cast<std::uint64_t>(directory.layers[l].x0_m));
    add(std::bit_cast<std::uint64_t>(directory.layers[l].y0_m));
    add(std::bit_cast<std::uint64_t>(directory.layers[l].pixel_m));
  }
  for (const MadeTile& tile : tiles) add(map_tile_digest(0, tile.file));
  return map_tile_digest(static_cast<std::uint64_t>(directory.body), facts);
}

double roughness_left(const std::vector<MadeTile>& tiles) {
  double before = 0, after = 0;
  for (const MadeTile& tile : tiles) {
    if (tile.place.layer != 0) continue;
    before += tile.rough_as_imaged;
    after += tile.rough_flat;
  }
  return before > 0 ? std::sqrt(after / before) : 1;
}

void clear_folder(const fs::path& folder) {
  std::vector<fs::path> old;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name == map_directory_name || (name.starts_with("tile-") && name.ends_with(".ilpt"))) old.push_back(entry);
  }
  // A directory without all of its tiles would be worse than none.
  std::sort(old.begin(), old.end());
  for (const fs::path& path : old) {
    std::error_code error;
    if (!fs::remove(path, error) && error) {
      throw std::runtime_error(path.string() + ": cannot be removed: " + error.message());
    }
  }
}

LayerSummary summary_of(const MapLayer& layer, std::uint32_t number, const std::vector<MadeTile>& tiles) {
  LayerSummary summary;
  summary.pixel_m = layer.pixel_m;
  std::size_t cells = 0, posts = 0;
  for (const MadeTile& tile : tiles) {
    if (tile.place.layer != number || tile.file.empty()) continue;
    ++summary.tiles;
    summary.bytes += tile.file.size();
    cells += tile.known_cells;
    posts += tile.known_posts;
  }
  summary.known_km2 = static_cast<double>(cells) * layer.pixel_m * layer.pixel_m / 1e6;
  if (summary.tiles > 0) {
    summary.known_heights = static_cast<double>(posts) / static_cast<double>(summary.tiles * map_tile_post_count);
  }
  return summary;
}

}  // namespace

void set_layers(MapDirectory& directory, double west_m, double north_m, double width_m, double height_m, double pixel_m,
                int coarse) {
  directory.layer_count = 0;
  for (const double pixel : {pixel_m, pixel_m * coarse}) {
    if (directory.layer_count == 1 && coarse <= 1) break;
    MapLayer& layer = directory.layers[directory.layer_count++];
    const auto tiles_of = [&](double length_m) {
      const double count = std::max(std::ceil(length_m / (map_tile_side * pixel) - 1e-9), 1.0);
      if (count > max_map_layer_side) {
        throw std::runtime_error("the area has " + host::brief(count) + " tiles along a side, and a map " +
                                 std::to_string(max_map_layer_side) +
                                 " at most: choose a smaller --area or a larger --pixel");
      }
      return static_cast<std::int32_t>(count);
    };
    layer = {pixel, west_m, north_m, tiles_of(width_m), tiles_of(height_m)};
    const std::size_t count = static_cast<std::size_t>(layer.columns) * static_cast<std::size_t>(layer.rows);
    // Rasters lie askew: some of the tiles know nothing.
    if (count > 8 * limits::max_map_tiles) {
      throw std::runtime_error("the area has " + std::to_string(count) + " tiles of " + host::brief(pixel) +
                               " m per pixel, and a map " + std::to_string(limits::max_map_tiles) +
                               " at most: choose a smaller --area or a larger --pixel");
    }
  }
}

MapSummary write_map(MapDirectory& directory, const PatchOf& patches, const TileParams& params,
                     std::span<const std::uint8_t> key, const fs::path& folder, std::ostream& messages) {
  host::make_output_folder(folder);
  std::vector<MadeTile> tiles = places_of(directory);
  make_tiles(directory, patches, params, tiles, messages);
  const auto known = static_cast<std::size_t>(
      std::count_if(tiles.begin(), tiles.end(), [](const MadeTile& tile) { return !tile.file.empty(); }));
  if (known == 0) throw std::runtime_error("the rasters have no data in the area");
  if (known > limits::max_map_tiles) {
    throw std::runtime_error("the area has " + std::to_string(known) + " tiles, and a map " +
                             std::to_string(limits::max_map_tiles) +
                             " at most: choose a smaller --area or a larger --pixel");
  }
  MapSummary summary;
  directory.id = summary.id = id_of(directory, tiles);
  summary.roughness_left = roughness_left(tiles);
  directory.light = params.flat ? MapLight::flat : MapLight::as_imaged;
  directory.tiles.clear();
  for (MadeTile& tile : tiles) {
    if (tile.file.empty()) continue;
    set_map_id(tile.file, directory.id);
    MapTileEntry entry;
    entry.digest = map_tile_digest(directory.id, tile.file);
    entry.bytes = static_cast<std::uint16_t>(tile.file.size());
    entry.layer = tile.place.layer;
    entry.row = tile.place.row;
    entry.column = tile.place.column;
    static_cast<void>(directory.tiles.push_back(entry));
  }
  Bytes bytes(max_map_directory_bytes);
  host::require(write_map_directory(directory, key, bytes, summary.directory_bytes), "the map's directory");
  bytes.resize(summary.directory_bytes);
  clear_folder(folder);
  for (const MadeTile& tile : tiles) {
    if (!tile.file.empty()) host::write_file(folder / map_tile_name(tile.place).c_str(), tile.file);
  }
  host::write_file(folder / map_directory_name, bytes);
  for (std::uint32_t l = 0; l < directory.layer_count; ++l) {
    summary.layers.push_back(summary_of(directory.layers[l], l, tiles));
  }
  return summary;
}

std::vector<std::string> lines_of(const MapSummary& summary) {
  std::vector<std::string> lines;
  std::size_t all = summary.directory_bytes;
  for (const LayerSummary& layer : summary.layers) {
    all += layer.bytes;
    std::string line = host::brief(layer.pixel_m) + " m per pixel: " + host::counted(layer.tiles, "tile") + ", " +
                       host::bytes_text(layer.bytes);
    if (layer.known_km2 > 0) {
      line += ", " + host::brief(layer.known_km2) + " km2, " +
              host::bytes_text(static_cast<std::uint64_t>(static_cast<double>(layer.bytes) / layer.known_km2)) +
              " per km2";
    }
    lines.push_back(line + ", heights of " + host::fixed(100 * layer.known_heights, 1) + " %");
  }
  if (summary.roughness_left > 1.05) {
    lines.push_back("warning: the image is " + host::fixed(100 * (summary.roughness_left - 1), 0) +
                    " % rougher without its shading: check --sun, and that image and heights fit");
  } else if (summary.roughness_left < 1) {
    lines.push_back("without its shading the image is " + host::fixed(100 * summary.roughness_left, 0) +
                    " % as rough as with it");
  }
  std::ostringstream id;
  id << std::hex << summary.id;
  lines.push_back("map " + id.str() + ": " + host::bytes_text(all) + " in all, " +
                  host::bytes_text(summary.directory_bytes) + " of them the directory");
  return lines;
}

}  // namespace ilp::maps
