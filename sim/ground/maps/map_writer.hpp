// Writes the files of a map, the directory and its tiles, from patches of ground.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "sim/ground/maps/tile_maker.hpp"

namespace ilp::maps {

/// Sets the layers of a map over an area of its plane: one with `pixel_m`, and if `coarse` is above 1 another with
/// `coarse` * `pixel_m`. Both begin at the north-western corner. Throws std::runtime_error if they need too many tiles.
void set_layers(MapDirectory& directory, double west_m, double north_m, double width_m, double height_m, double pixel_m,
                int coarse);

struct LayerSummary {
  double pixel_m = 0;
  std::size_t tiles = 0, bytes = 0;
  double known_km2 = 0;      ///< area with a known image
  double known_heights = 0;  ///< share of posts with a known height, 0 to 1
};

struct MapSummary {
  std::uint64_t id = 0;
  std::vector<LayerSummary> layers;
  std::size_t directory_bytes = 0;
  /// Ratio of the finest layer's roughness after division by the shading to that before; 1: not divided.
  double roughness_left = 1;
};

/// Writes all tiles of the directory's layers with any known ground, then the directory. Removes the files of another
/// map from the folder before. `directory` must be complete except for id, light and tiles, which are set. `patches` is
/// called by one thread at a time. `key`: signs the directory; empty: not signed. The same ground gives the same bytes.
/// Throws std::runtime_error if no ground is known, the map has more than limits::max_map_tiles tiles, or the folder
/// cannot be written; also throws what `patches` throws.
MapSummary write_map(MapDirectory& directory, const PatchOf& patches, const TileParams& params,
                     std::span<const std::uint8_t> key, const std::filesystem::path& folder, std::ostream& messages);

/// A few lines for the user.
[[nodiscard]] std::vector<std::string> lines_of(const MapSummary& summary);

}  // namespace ilp::maps
