// Reads a raster file of one band, of any size and any format that GDAL reads, in blocks, with georeference, units,
// scale and missing values.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "sim/host/gdal_session.hpp"
#include "sim/host/height_units.hpp"
#include "sim/host/raster.hpp"

namespace ilp::host {

/// GDAL's affine transform t: x = t[0] + column * t[1] + row * t[2], y = t[3] + column * t[4] + row * t[5]. Column and
/// row 0 are the outer corner of the first pixel.
using GeoTransform = std::array<double, 6>;

class RasterBand {
 public:
  enum class Content { heights, brightness };

  /// Opens the file. Throws std::runtime_error that names the file if it is no raster, has several bands, fewer than
  /// two pixels a side or no georeference, or if heights have an unknown unit. The unit of brightness is ignored.
  RasterBand(std::filesystem::path path, Content content);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] const GeoTransform& transform() const { return transform_; }
  /// Null if the file states no coordinate system.
  [[nodiscard]] const OGRSpatialReference* system() const;
  /// The band's unit as written in the file; may be empty.
  [[nodiscard]] std::string unit() const { return dataset_->GetRasterBand(1)->GetUnitType(); }

  /// Reads `width` x `height` cells from pixel (x, y) on. A cell is the mean of `factor` x `factor` pixels, which must
  /// lie inside the file. Heights are in metres; NaN where all pixels of a cell are missing. Not thread-safe.
  [[nodiscard]] Raster<float> read(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                                   std::int32_t factor);

 private:
  void average(Raster<float>& block, std::int32_t x, std::int32_t y, std::int32_t factor);
  void clear_missing(Raster<float>& block, std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height);

  std::filesystem::path path_;
  GdalSession session_;
  Dataset dataset_;
  std::int32_t columns_ = 0, rows_ = 0;
  GeoTransform transform_{};
  HeightUnits units_;
  bool masked_ = false;
};

}  // namespace ilp::host
