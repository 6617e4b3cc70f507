// Decodes and encodes tiles of a map: an image of 256 x 256 px, heights on posts, and features for place recognition
// without a prior. The files are compressed; decoding takes fixed memory and bounded time.
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
  /// Grey values 1 to 255, proportional to the light; 0: unknown.
  std::array<std::uint8_t, map_tile_pixels> image{};
  /// Heights in steps of height_step_m. Post (i, j) is 4 i pixels east and 4 j pixels south of the tile's north-western
  /// corner. unknown_post where the height is not known.
  std::array<std::int16_t, map_tile_post_count> posts{};

  [[nodiscard]] bool is_known(std::int32_t i, std::int32_t j) const { return post(i, j) != unknown_post; }
  [[nodiscard]] double height_m(std::int32_t i, std::int32_t j) const {
    return height_offset_m + height_step_m * static_cast<double>(post(i, j));
  }
  [[nodiscard]] std::int16_t post(std::int32_t i, std::int32_t j) const {
    return posts[static_cast<std::size_t>(j) * map_tile_posts + static_cast<std::size_t>(i)];
  }
};

/// Features are detected in a picture of the tile that is enlarged by this factor, because a tile has too few pixels
/// for many features. Their levels and descriptors refer to this picture.
inline constexpr std::int32_t map_feature_zoom = 2;

/// Features with positions in px of the tile, pixel centres at integers.
using MapFeatures = FixedVector<PlaceFeature, limits::max_map_features>;
/// The features of a tile for one direction of the sun.
struct MapTileFeatures {
  MapFeatures image;  ///< features of the image; empty if the image's own sun is far from that direction
  MapFeatures shape;  ///< features of the shaded heights; empty if `image` is used
};

/// Scratch of decoding and encoding a tile. Nothing is kept between calls.
struct MapTileWorkspace {
  std::array<std::int32_t, map_tile_pixels> samples, scratch;
  std::array<std::uint8_t, map_tile_pixels> mask;
};

/// Decodes the file of an entry. Returns `record_damaged` (first value: index of the entry) if its size or digest is
/// not that of the directory. Returns `truncated`, `parse_error` (first value: offset) or `unsupported_format` (first
/// value: version) if the digest is right but the file was written wrongly. After a fault `tile` is undefined.
Status decode_map_tile(std::span<const std::uint8_t> file, const MapDirectory& directory, std::size_t entry,
                       MapTileWorkspace& workspace, MapTile& tile);

/// Reads the features of a tile; both lists are empty if the map has none. Returns the faults of decode_map_tile.
Status read_map_features(std::span<const std::uint8_t> file, const MapDirectory& directory, std::size_t entry,
                         MapTileFeatures& features);

struct MapTileCoding {
  std::size_t image_bytes = map_tile_pixels / 16;  ///< most bytes of the image without its mask: 0.5 bit per pixel
};

/// Writes a tile's file, for the ground segment; `size` gets the number of bytes. Heights and masks are lossless; the
/// image has the quality that coding.image_bytes allows. Returns `capacity_exceeded` if the file does not fit, and
/// `invalid_argument` for features outside the tile.
Status encode_map_tile(const MapTile& tile, const MapTileFeatures& features, std::uint64_t map_id,
                       const MapTileCoding& coding, MapTileWorkspace& workspace, std::span<std::uint8_t> file,
                       std::size_t& size);

/// Replaces the map's id in a file of encode_map_tile.
void set_map_id(std::span<std::uint8_t> file, std::uint64_t map_id);

}  // namespace ilp
