// One-band rasters of heights or brightness: GeoTIFF (OGC 19-008r4) and grey PNG, read and written by GDAL.
// Every function throws std::runtime_error that names the file and what was expected.
#pragma once

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
  Raster<float> values;  ///< not a number where the file has no value, declared or not
  std::optional<RasterPlace> place;
};

/// TIFF or PNG, recognised by content.
[[nodiscard]] bool is_raster_file(const std::filesystem::path& path);

/// One band of integers or of floating-point numbers, in metres by their scale, offset and unit (height_units.hpp); a
/// plane in feet becomes one in metres. Refused: colour, several bands, rotated rasters, degrees instead
/// of metres, damaged files. A PNG has no place.
[[nodiscard]] GeoRaster read_raster(const std::filesystem::path& path);

/// Deflate; a local engineering system of coordinates in metres. Values that are not numbers are declared missing.
void write_geotiff(const std::filesystem::path& path, ImageView<const float> values, const RasterPlace& place);

}  // namespace ilp::host
