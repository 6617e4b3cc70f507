// Reads rasters of heights or brightness with one band from GeoTIFF (OGC 19-008r4) and grey PNG, and writes GeoTIFF, by
// GDAL. Every function throws std::runtime_error that names the file and what was expected.
#pragma once

#include <filesystem>
#include <optional>

#include "fsw/base/image_view.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::host {

/// Position of a raster in m: (x, y) is the centre of the first pixel of the first row. The spacings between pixel
/// centres are positive; y decreases from row to row.
struct RasterPlace {
  double x = 0, y = 0;
  double spacing_x = 1, spacing_y = 1;
};

struct GeoRaster {
  Raster<float> values;              ///< NaN where the value is missing (HeightUnits::is_missing)
  std::optional<RasterPlace> place;  ///< empty for a PNG, and for a TIFF without georeference
};

/// Whether the file is a TIFF or PNG, recognised by content.
[[nodiscard]] bool is_raster_file(const std::filesystem::path& path);

/// Reads a band of integers or floating-point numbers and converts values to metres by scale, offset and unit
/// (height_units.hpp), and coordinates in feet to metres. Refuses colour, several bands, rotated rasters, coordinates
/// in degrees, and damaged files.
[[nodiscard]] GeoRaster read_raster(const std::filesystem::path& path);

/// Writes a band of floats with Deflate compression, in a local engineering coordinate system in metres. NaN is
/// declared as the missing value.
void write_geotiff(const std::filesystem::path& path, ImageView<const float> values, const RasterPlace& place);

}  // namespace ilp::host
