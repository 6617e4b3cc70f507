// One tile of a map: an image of 256 x 256 px, heights on posts, and features by which the ground is recognised without
// knowing where it is. As bytes it is compressed; decoding takes fixed memory and a bounded time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "fsw/maps/map_directory.hpp"
#include "fsw/vision/place/place_features.hpp"

namespace ilp {

inline constexpr std::size_t map_tile_pixels = std::size_t{map_tile_side} * map_tile_side;
inline constexpr std::size_t map_tile_post_count = std::size_t{map_tile_posts} * map_tile_posts;
inline constexpr std::int16_t unknown_post = std::numeric_limits<std::int16_t>::min();

/// Row 0 is the northern edge.
struct MapTile {
  std::uint16_t layer = 0, row = 0, column = 0;
  double height_offset_m = 0, height_step_m = 1;
  /// 0: unknown; 1 to 255, proportional to the light.
  std::array<std::uint8_t, map_tile_pixels> image{};
  /// In steps, at the corners of pixels: post (i, j) stands 4 i pixels east and 4 j pixels south of the tile's
  /// north-western corner. unknown_post where nothing is known.
  std::array<std::int16_t, map_tile_post_count> posts{};

  [[nodiscard]] bool is_known(std::int32_t i, std::int32_t j) const { return post(i, j) != unknown_post; }
  [[nodiscard]] double height_m(std::int32_t i, std::int32_t j) const {
    return height_offset_m + height_step_m * static_cast<double>(post(i, j));
  }
  [[nodiscard]] std::int16_t post(std::int32_t i, std::int32_t j) const {
    return posts[static_cast<std::size_t>(j) * map_tile_posts + static_cast<std::size_t>(i)];
  }
};

/// Features are found in pictures that have so many pixels along one of the tile, and their levels and descriptors
/// belong to these: a tile has too few pixels for many features, and a keyframe on its grid likewise.
inline constexpr std::int32_t map_feature_zoom = 2;

/// Places in px of the tile, pixel centres at integers.
using MapFeatures = FixedVector<PlaceFeature, limits::max_map_features>;
struct MapTileFeatures {
  MapFeatures image;  ///< of the image under the sun that was meant; empty where that is far from the image's own
  MapFeatures shape;  ///< of the shading of the heights under that sun; empty where the image serves
};

/// Scratch of decoding and encoding a tile. It carries nothing from call to call.
struct MapTileWorkspace {
  std::array<std::int32_t, map_tile_pixels> samples, scratch;
  std::array<std::uint8_t, map_tile_pixels> mask;
};

/// Decodes the file of an entry. `record_damaged` (a = the entry's index): it is not the file that the directory means
/// (size, digest); `truncated`, `parse_error` (a = offset), `unsupported_format` (a = version): a file that the digest
/// covers, and that was written wrongly. After an error `tile` is void.
Status decode_map_tile(std::span<const std::uint8_t> file, const MapDirectory& directory, std::size_t entry,
                       MapTileWorkspace& workspace, MapTile& tile);

/// Its features; both lists are empty in a map without them. Errors as above.
Status read_map_features(std::span<const std::uint8_t> file, const MapDirectory& directory, std::size_t entry,
                         MapTileFeatures& features);

struct MapTileCoding {
  std::size_t image_bytes = map_tile_pixels / 16;  ///< ceiling of the image's section, beside its mask: 0.5 bit a pixel
};

/// Writes a tile's file; `size` is the number of bytes. Heights and masks are exact; the image keeps what its ceiling
/// allows. `capacity_exceeded`; `invalid_argument` for features outside the tile. For the ground.
Status encode_map_tile(const MapTile& tile, const MapTileFeatures& features, std::uint64_t map_id,
                       const MapTileCoding& coding, MapTileWorkspace& workspace, std::span<std::uint8_t> file,
                       std::size_t& size);

/// Gives the file of encode_map_tile to another map.
void set_map_id(std::span<std::uint8_t> file, std::uint64_t map_id);

}  // namespace ilp
