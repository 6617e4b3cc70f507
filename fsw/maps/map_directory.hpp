// The directory of a map that an orbiter made of the ground: where it lies on the body, its layers and its tiles. The
// ground makes it (`ilp-ground map-tiles`), the flight reads it (docs/map-relative.md).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "cfg/choices.hpp"
#include "cfg/limits.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::int32_t map_tile_side = 256;   ///< px
inline constexpr std::int32_t map_post_spacing = 4;  ///< px between posts of height
inline constexpr std::int32_t map_tile_posts = 65;   ///< on a side of a tile; the last is the first of the next tile
inline constexpr std::int32_t max_map_layer_side = 4096;  ///< tiles

/// What the map's image shows. Grey is light: level ground of mean brightness has 128, and twice as much light is 255.
ILP_ENUMERATION(MapLight, (0, as_imaged, "the ground as the sun of the map's image lit it"),
                (1, flat, "the same divided by the shading of the map's heights, where they are known"))

/// A grid of tiles. Cell (c, r) of the layer, in pixels, has its centre at x = x0_m + (c + 0.5) * pixel_m and
/// y = y0_m - (r + 0.5) * pixel_m: rows go from the north to the south. Tile (row, column) has the cells from
/// (column * 256, row * 256) on.
struct MapLayer {
  double pixel_m = 0;
  double x0_m = 0, y0_m = 0;           ///< north-west corner of the first cell
  std::int32_t columns = 0, rows = 0;  ///< tiles
};

/// Tiles without any known ground have no entry.
struct MapTileEntry {
  std::uint64_t digest = 0;  ///< of the tile's file: map_tile_digest
  std::uint16_t bytes = 0;   ///< of the tile's file
  std::uint16_t layer = 0, row = 0, column = 0;
};
static_assert(sizeof(MapTileEntry) == 16 && std::is_trivially_copyable_v<MapTileEntry>);

/// Map coordinates: x to the east, y to the north, in metres, in the transverse Mercator projection of the body's
/// figure (degree_lengths) with its centre and true scale at the origin; z is the height above the body's figure or
/// areoid, as the product has it. The map of a simulated world has the world's x, y and z.
struct MapDirectory {
  std::uint64_t id = 0;  ///< of the map; each of its tiles carries it
  Body body = Body::none;
  MapLight light = MapLight::as_imaged;
  double longitude_rad = 0, latitude_rad = 0;         ///< of the origin; east positive, planetocentric on a sphere
  double sun_azimuth_rad = 0, sun_elevation_rad = 0;  ///< of the image: towards it from x to y, above the horizon
  double ambient = 0;         ///< share of the light on level ground that comes from the whole sky, 0 to 1
  double image_sigma = 0;     ///< of the image's noise, grey levels
  double height_sigma_m = 0;  ///< of the heights, slowly varying over the ground
  double place_sigma_m = 0;   ///< of the place of the map as a whole, per axis
  std::uint32_t layer_count = 0;
  MapLayer layers[limits::max_map_layers];                 ///< the finest first
  FixedVector<MapTileEntry, limits::max_map_tiles> tiles;  ///< in order of layer, row, column; no two are the same
};

/// The largest size of a directory as bytes.
inline constexpr std::size_t max_map_directory_bytes = 256 + limits::max_map_tiles * 16;

/// Reads a directory from bytes, of which none is trusted. With a key (16 to 64 octets) it must be signed with that
/// key; without one, signatures are not looked at. `truncated`, `parse_error` (a = offset), `unsupported_format` (a =
/// the version), `map_not_authentic`. After an error `directory` is void.
Status parse_map_directory(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> key,
                           MapDirectory& directory);

/// Writes it, signed if there is a key; `size` is the number of bytes. `capacity_exceeded`, or the fault for which
/// parse_map_directory would refuse it.
Status write_map_directory(const MapDirectory& directory, std::span<const std::uint8_t> key,
                           std::span<std::uint8_t> bytes, std::size_t& size);

/// The index of a tile in `directory.tiles`, or their number if there is none.
[[nodiscard]] std::size_t find_map_tile(const MapDirectory& directory, std::uint32_t layer, std::int32_t row,
                                        std::int32_t column);

/// First octets of the HMAC-SHA-256 of the tile's file, with the map's id as the key. As the signed directory holds it,
/// nobody without the directory's key can give another tile to the flight.
[[nodiscard]] std::uint64_t map_tile_digest(std::uint64_t map_id, std::span<const std::uint8_t> file);
/// Whether the file is the tile that the directory names: neither damaged nor of another map.
[[nodiscard]] bool is_map_tile(const MapDirectory& directory, const MapTileEntry& entry,
                               std::span<const std::uint8_t> file);

}  // namespace ilp
