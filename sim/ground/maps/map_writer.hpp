// Makes the files of a map from pieces of ground: the directory and its tiles.
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

/// The layers of a map over an area of its plane: `pixel_m`, and `coarse` times as much where that is above 1. Both
/// begin at the north-western corner. std::runtime_error for far more tiles than a map has.
void set_layers(MapDirectory& directory, double west_m, double north_m, double width_m, double height_m, double pixel_m,
                int coarse);

struct LayerSummary {
  double pixel_m = 0;
  std::size_t tiles = 0, bytes = 0;
  double known_km2 = 0;      ///< of the image
  double known_heights = 0;  ///< share of the posts
};

struct MapSummary {
  std::uint64_t id = 0;
  std::vector<LayerSummary> layers;
  std::size_t directory_bytes = 0;
  /// Roughness of the finest layer after its shading was divided out, over that before; 1 where it was not.
  double roughness_left = 1;
};

/// Makes and writes all tiles of the directory's layers that know any ground, then the directory, signed if there is a
/// key; what another map left in the folder is removed before. `directory` is complete but for id, light, tiles. The
/// same ground gives the same bytes. std::runtime_error: more than limits::max_map_tiles tiles, a folder that cannot be
/// written, and what `pieces` throws, which is called by one thread at a time.
MapSummary write_map(MapDirectory& directory, const PatchOf& patches, const TileParams& params,
                     std::span<const std::uint8_t> key, const std::filesystem::path& folder, std::ostream& messages);

/// A few lines for people.
[[nodiscard]] std::vector<std::string> lines_of(const MapSummary& summary);

}  // namespace ilp::maps
