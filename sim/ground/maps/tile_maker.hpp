// A tile of a map from a piece of ground.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "fsw/maps/map_tile.hpp"
#include "hal/maps/map_source.hpp"
#include "sim/ground/maps/map_patches.hpp"

namespace ilp::maps {

/// Cells of a piece beyond the tile on each side: features at its border need them.
inline constexpr std::int32_t tile_margin = 32;

struct TileParams {
  Sun sun;                        ///< of the image
  bool flat = true;               ///< divide the image by its shading
  std::size_t features = 256;     ///< of a tile
  std::optional<Sun> flight_sun;  ///< that the features are for; none: that of the image
  double image_bits = 0.5;        ///< per pixel
  double height_step_px = 0.02;   ///< of posts
};

/// Which tile, and the piece of ground around it, which is tile_margin larger on every side.
[[nodiscard]] PatchArea area_of_tile(std::int32_t row, std::int32_t column);

class TileMaker {
 public:
  explicit TileMaker(const TileParams& params);
  ~TileMaker();

  struct Made {
    std::vector<std::uint8_t> file;  ///< with map id 0; empty if the piece knows nothing of the tile
    std::size_t known_cells = 0, known_posts = 0;
    double rough_as_imaged = 0, rough_flat = 0;  ///< of the light (roughness_of); equal where it is not divided
  };
  /// std::runtime_error for heights that no tile holds.
  [[nodiscard]] Made make(const MapLayer& layer, const MapTilePlace& place, MapPatch patch);

 private:
  struct Memory;
  TileParams params_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace ilp::maps
