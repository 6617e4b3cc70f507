// The directory of an orbiter's map: its position on the body, its layers and its tiles. The ground segment makes it
// (`ilp-ground map-tiles`), the flight reads it (docs/map-relative.md).
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
inline constexpr std::int32_t map_post_spacing = 4;  ///< px between height posts
inline constexpr std::int32_t map_tile_posts = 65;   ///< posts along a tile's side; the last is the next tile's first
inline constexpr std::int32_t max_map_layer_side = 4096;  ///< tiles

/// What the map's image shows. Grey values are proportional to light: level ground of mean brightness has 128.
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

/// A tile in the directory. Tiles without any known ground have no entry.
struct MapTileEntry {
  std::uint64_t digest = 0;  ///< map_tile_digest() of the tile's file
  std::uint16_t bytes = 0;   ///< size of the tile's file
  std::uint16_t layer = 0, row = 0, column = 0;
};
static_assert(sizeof(MapTileEntry) == 16 && std::is_trivially_copyable_v<MapTileEntry>);

/// Map coordinates in metres: x to the east and y to the north in the transverse Mercator projection of the body's
/// ellipsoid (local_plane.hpp) with its centre and true scale at the origin; z is the height above the ellipsoid or
/// areoid, as in the source of the map. The map of a simulated world has the world's x, y and z.
struct MapDirectory {
  std::uint64_t id = 0;  ///< id of the map, which each of its tiles contains
  Body body = Body::none;
  MapLight light = MapLight::as_imaged;
  double longitude_rad = 0, latitude_rad = 0;  ///< origin; longitude positive to the east; latitude planetographic
  double sun_azimuth_rad = 0, sun_elevation_rad = 0;  ///< sun of the image: azimuth from x to y, elevation over horizon
  double ambient = 0;         ///< share of the light on level ground that comes from the whole sky, 0 to 1
  double image_sigma = 0;     ///< standard deviation of the image's noise, grey levels
  double height_sigma_m = 0;  ///< standard deviation of the heights; the error varies slowly over the ground
  double place_sigma_m = 0;   ///< standard deviation of the position of the complete map, per axis
  std::uint32_t layer_count = 0;
  MapLayer layers[limits::max_map_layers];                 ///< the finest first
  FixedVector<MapTileEntry, limits::max_map_tiles> tiles;  ///< in order of layer, row, column; no two are the same
};

/// The largest size of a directory file.
inline constexpr std::size_t max_map_directory_bytes = 256 + limits::max_map_tiles * 16;

/// Reads a directory from untrusted bytes. With a key (16 to 64 octets) it must be signed with that key; with an empty
/// key the signature is not checked. Returns `truncated`, `parse_error` (first value: offset), `unsupported_format`
/// (first value: version) or `map_not_authentic` (no or wrong signature). After a fault `directory` is undefined.
Status parse_map_directory(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t> key,
                           MapDirectory& directory);

/// Writes a directory, signed if `key` is not empty; `size` gets the number of bytes. Returns `capacity_exceeded` if it
/// does not fit, or the fault for which parse_map_directory would refuse it.
Status write_map_directory(const MapDirectory& directory, std::span<const std::uint8_t> key,
                           std::span<std::uint8_t> bytes, std::size_t& size);

/// The index of a tile in `directory.tiles`; the number of tiles if there is no such tile.
[[nodiscard]] std::size_t find_map_tile(const MapDirectory& directory, std::uint32_t layer, std::int32_t row,
                                        std::int32_t column);

/// The first eight octets of the HMAC-SHA-256 of the tile's file, with the map's id as key. Because the signed
/// directory contains it, nobody without the directory's key can make the flight accept another tile.
[[nodiscard]] std::uint64_t map_tile_digest(std::uint64_t map_id, std::span<const std::uint8_t> file);
/// Whether the file is the tile of the entry, neither damaged nor from another map.
[[nodiscard]] bool is_map_tile(const MapDirectory& directory, const MapTileEntry& entry,
                               std::span<const std::uint8_t> file);

}  // namespace ilp
