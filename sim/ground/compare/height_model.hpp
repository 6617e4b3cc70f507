// Heights in a raster file of any size and any format that GDAL reads. Only a few blocks are in memory at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <unordered_map>
#include <utility>

#include "sim/host/raster_band.hpp"

namespace ilp::compare {

/// Rasters are read and written in blocks of this many cells a side.
inline constexpr std::int32_t block_side = 256;

using host::GeoTransform;

class HeightModel {
 public:
  /// std::runtime_error names the file and says what is wrong: no raster, several bands, fewer than two pixels a side,
  /// no position, an unknown unit of heights.
  explicit HeightModel(std::filesystem::path path) : band_(std::move(path), host::RasterBand::Content::heights) {}

  [[nodiscard]] const std::filesystem::path& path() const { return band_.path(); }
  [[nodiscard]] std::int32_t columns() const { return band_.columns(); }
  [[nodiscard]] std::int32_t rows() const { return band_.rows(); }
  [[nodiscard]] const GeoTransform& transform() const { return band_.transform(); }
  /// Null where the file states no coordinate system.
  [[nodiscard]] const OGRSpatialReference* system() const { return band_.system(); }

  /// From now on the model has cells of `factor` x `factor` pixels, each with the mean of its pixels (by GDAL). Rows
  /// and columns that are left over at the end fall away.
  void reduce(std::int32_t factor);
  [[nodiscard]] std::int32_t factor() const { return factor_; }
  [[nodiscard]] std::int32_t reduced_columns() const { return columns() / factor_; }
  [[nodiscard]] std::int32_t reduced_rows() const { return rows() / factor_; }

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

  host::RasterBand band_;
  std::int32_t factor_ = 1;
  // The newest used block is the first.
  std::list<std::pair<std::int64_t, Block>> blocks_;
  std::unordered_map<std::int64_t, decltype(blocks_)::iterator> where_;
};

}  // namespace ilp::compare
