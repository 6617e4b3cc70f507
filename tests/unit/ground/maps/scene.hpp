// Rasters of an orbiter whose content is known in longitude and latitude, and maps that are read back from a folder.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fsw/maps/map_tile.hpp"
#include "sim/ground/maps/map_tiles.hpp"

namespace ilp::test {

struct RasterFile {
  std::string system;  ///< for PROJ; empty: none
  std::int32_t columns = 0, rows = 0;
  double t[6] = {};  ///< GDAL's transform; t[1] = 0: none
  enum class Type { f32, i16, u8 } type = Type::f32;
  double scale = 1, offset = 0;
  double missing = 1e300;  ///< 1e300: none declared
  std::string unit;
  int bands = 1;
  bool empty = false;  ///< nothing is written: a large file takes no room
};

/// Writes a GeoTIFF with value(x, y) at the pixels' centres, in the raster's own coordinates. The stored value is
/// (value - offset) / scale.
void write_raster(const std::filesystem::path& path, const RasterFile& file,
                  const std::function<double(double, double)>& value);

/// The whole of a map's folder.
struct ReadMap {
  std::unique_ptr<MapDirectory> directory = std::make_unique<MapDirectory>();
  std::vector<std::unique_ptr<MapTile>> tiles;  ///< in the directory's order
  std::vector<MapTileFeatures> features;

  /// 0 where nothing is known.
  [[nodiscard]] int grey(std::uint32_t layer, std::int32_t column, std::int32_t row) const;
  /// The centre of brightness above `floor` in the square of +-radius cells about a place: x and y, m.
  [[nodiscard]] maps::Place centre_of_light(std::uint32_t layer, maps::Place about, std::int32_t radius,
                                            double floor) const;
};
[[nodiscard]] ReadMap read_map(const std::filesystem::path& folder, std::span<const std::uint8_t> key = {});

/// Of a sphere (Snyder, Map Projections, 1987, equations 8-1 to 8-3), in degrees and m.
[[nodiscard]] maps::Place transverse_mercator(double radius_m, double longitude0, double latitude0, double longitude,
                                              double latitude);

}  // namespace ilp::test
