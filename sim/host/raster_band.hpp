// One band of a raster file of any size and any format that GDAL reads, with its place, units, scale and missing
// values.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include "sim/host/gdal_session.hpp"
#include "sim/host/height_units.hpp"
#include "sim/host/raster.hpp"

namespace ilp::host {

/// Affine: x = t[0] + column t[1] + row t[2], y = t[3] + column t[4] + row t[5]; (0, 0) is the corner of the first
/// pixel, as GDAL has it.
using GeoTransform = std::array<double, 6>;

class RasterBand {
 public:
  enum class Content { heights, brightness };

  /// std::runtime_error names the file and says what is wrong: no raster, several bands, fewer than two pixels a side,
  /// no position, an unknown unit of heights. A brightness has any unit.
  RasterBand(std::filesystem::path path, Content content);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] const GeoTransform& transform() const { return transform_; }
  /// Null where the file states no coordinate system.
  [[nodiscard]] const OGRSpatialReference* system() const;
  /// The band's unit as the file writes it.
  [[nodiscard]] std::string unit() const { return dataset_->GetRasterBand(1)->GetUnitType(); }

  /// `width` x `height` cells of `factor` x `factor` pixels, each with the mean of its pixels (by GDAL), from the pixel
  /// (x, y) on; all lie inside. Heights are metres; NaN where nothing is known. Not from several threads at once.
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
