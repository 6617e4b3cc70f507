// Makes the file of one map tile from a patch of ground.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "fsw/maps/map_tile.hpp"
#include "hal/maps/map_source.hpp"
#include "sim/ground/maps/map_patches.hpp"

namespace ilp::maps {

/// Cells by which a patch extends beyond its tile on each side, because features at the tile's border need them.
inline constexpr std::int32_t tile_margin = 32;

struct TileParams {
  Sun sun;                        ///< sun in the image
  bool flat = true;               ///< divide the image by its shading
  std::size_t features = 256;     ///< features per tile
  std::optional<Sun> flight_sun;  ///< sun for which the features are computed; none: that of the image
  double image_bits = 0.5;        ///< bits per pixel of the coded image
  double height_step_px = 0.02;   ///< quantisation step of the posts, pixels of the layer
};

/// The area of a tile's patch: the tile and tile_margin cells more on each side.
[[nodiscard]] PatchArea area_of_tile(std::int32_t row, std::int32_t column);

class TileMaker {
 public:
  explicit TileMaker(const TileParams& params);
  ~TileMaker();

  struct Made {
    std::vector<std::uint8_t> file;  ///< with map id 0; empty if nothing of the tile is known
    std::size_t known_cells = 0, known_posts = 0;
    /// Roughness of the light (roughness_of) before and after division by the shading; equal if it is not divided.
    double rough_as_imaged = 0, rough_flat = 0;
  };
  /// Makes the tile's file. Throws std::runtime_error for heights outside the range of a tile.
  [[nodiscard]] Made make(const MapLayer& layer, const MapTilePlace& place, MapPatch patch);

 private:
  struct Memory;
  TileParams params_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace ilp::maps
