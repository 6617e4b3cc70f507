// Heights in a raster file of any size and any format that GDAL reads. Only a few blocks are in memory at a time.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <list>
#include <string>
#include <unordered_map>
#include <utility>

#include "sim/host/gdal_session.hpp"
#include "sim/host/height_units.hpp"
#include "sim/host/raster.hpp"

namespace ilp::compare {

/// Rasters are read and written in blocks of this many cells a side.
inline constexpr std::int32_t block_side = 256;

/// Affine: x = t[0] + column t[1] + row t[2], y = t[3] + column t[4] + row t[5]; (0, 0) is the corner of the first
/// pixel, as GDAL has it.
using GeoTransform = std::array<double, 6>;

class HeightModel {
 public:
  /// std::runtime_error names the file and says what is wrong: no raster, several bands, fewer than two pixels a side,
  /// no position, an unknown unit of heights.
  explicit HeightModel(std::filesystem::path path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::int32_t columns() const { return columns_; }
  [[nodiscard]] std::int32_t rows() const { return rows_; }
  [[nodiscard]] const GeoTransform& transform() const { return transform_; }
  /// Null where the file states no coordinate system.
  [[nodiscard]] const OGRSpatialReference* system() const;

  /// From now on the model has cells of `factor` x `factor` pixels, each with the mean of its pixels (by GDAL). Rows
  /// and columns that are left over at the end fall away.
  void reduce(std::int32_t factor);
  [[nodiscard]] std::int32_t factor() const { return factor_; }
  [[nodiscard]] std::int32_t reduced_columns() const { return columns_ / factor_; }
  [[nodiscard]] std::int32_t reduced_rows() const { return rows_ / factor_; }

  /// Metres; NaN where there is none. Indices of reduced cells, which must lie inside.
  [[nodiscard]] float cell(std::int32_t column, std::int32_t row);

  struct Sample {
    double height = 0;                   ///< NaN outside and beside holes
    double per_column = 0, per_row = 0;  ///< its gradient, metres per pixel of the file; NaN at the border
  };
  /// Bilinear between the centres of reduced cells. Column and row count pixels of the file, with the centre of the
  /// first pixel at (0, 0).
  [[nodiscard]] Sample at(double column, double row);
  [[nodiscard]] double height_at(double column, double row);
  /// Whether the place lies between the centres of the outermost reduced cells.
  [[nodiscard]] bool contains(double column, double row) const;

 private:
  using Block = host::Raster<float>;
  [[nodiscard]] const Block& block(std::int32_t column, std::int32_t row);
  [[nodiscard]] Block read_block(std::int32_t column, std::int32_t row);
  void average(Block& block, std::int32_t x, std::int32_t y);
  void clear_missing(Block& block, std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height);

  std::filesystem::path path_;
  host::GdalSession session_;
  host::Dataset dataset_;
  std::int32_t columns_ = 0, rows_ = 0, factor_ = 1;
  GeoTransform transform_{};
  host::HeightUnits units_;
  bool masked_ = false;
  // The newest used block is the first.
  std::list<std::pair<std::int64_t, Block>> blocks_;
  std::unordered_map<std::int64_t, decltype(blocks_)::iterator> where_;
};

}  // namespace ilp::compare
