// One-band GeoTIFF rasters: heights, brightness, masks. OGC GeoTIFF 1.1 (19-008r4); missing values as GDAL writes them.
// Every function throws std::runtime_error that names the file and what was expected.
//
// Files are read with libtiff and not with GDAL, which the ground uses: GDAL opens the database of PROJ with SQLite,
// and flight software, which flies in the same process, has to configure SQLite before its first use.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "fsw/base/image_view.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::host {

/// Where the pixels lie: (x, y) of the centre of the first row's first pixel, and the distance between centres, both
/// positive; y falls from row to row. Metres.
struct RasterPlace {
  double x = 0, y = 0;
  double spacing_x = 1, spacing_y = 1;
};

struct GeoRaster {
  Image<float> values;  ///< not a number where the file has no value
  std::optional<RasterPlace> place;
};

/// Told by content.
[[nodiscard]] bool is_tiff(const std::filesystem::path& path);

/// One band of 8, 16 or 32-bit integers or of floating-point numbers, in strips or tiles, compressed as libtiff knows.
/// Refused: colour, several bands, rotated rasters, degrees instead of metres.
[[nodiscard]] GeoRaster read_geotiff(const std::filesystem::path& path);

/// Deflate; a local engineering system of coordinates in metres. Values that are not numbers are declared missing.
void write_geotiff(const std::filesystem::path& path, ImageView<const float> values, const RasterPlace& place);
/// `missing`: the value that stands for none.
void write_geotiff(const std::filesystem::path& path, ImageView<const std::uint8_t> values, const RasterPlace& place,
                   std::optional<std::uint8_t> missing = {});

}  // namespace ilp::host
