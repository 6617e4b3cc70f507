// Reads heights from a raster file of any size and any format of GDAL. Only a few blocks are in memory at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <list>
#include <unordered_map>
#include <utility>

#include "sim/host/raster_band.hpp"

namespace ilp::compare {

/// Side of the blocks in which rasters are read and written, cells.
inline constexpr std::int32_t block_side = 256;

using host::GeoTransform;

class HeightModel {
 public:
  /// Throws std::runtime_error, which names the file and says what is wrong, if it is no raster, has several bands,
  /// fewer than two columns or rows, no georeference, or an unknown unit of heights.
  explicit HeightModel(std::filesystem::path path) : band_(std::move(path), host::RasterBand::Content::heights) {}

  [[nodiscard]] const std::filesystem::path& path() const { return band_.path(); }
  [[nodiscard]] std::int32_t columns() const { return band_.columns(); }
  [[nodiscard]] std::int32_t rows() const { return band_.rows(); }
  [[nodiscard]] const GeoTransform& transform() const { return band_.transform(); }
  /// Null if the file states no coordinate system.
  [[nodiscard]] const OGRSpatialReference* system() const { return band_.system(); }

  /// Sets the size of the model's cells to `factor` x `factor` pixels; a cell has the mean of its pixels (by GDAL).
  /// Remaining pixels at the right and lower edge are left out.
  void reduce(std::int32_t factor);
  [[nodiscard]] std::int32_t factor() const { return factor_; }
  [[nodiscard]] std::int32_t reduced_columns() const { return columns() / factor_; }
  [[nodiscard]] std::int32_t reduced_rows() const { return rows() / factor_; }

  /// Height of a reduced cell, metres; NaN: no height. The cell must be in the model.
  [[nodiscard]] float cell(std::int32_t column, std::int32_t row);

  struct Sample {
    double height = 0;                   ///< metres; NaN outside the model and next to cells without a height
    double per_column = 0, per_row = 0;  ///< gradient, metres per pixel of the file; NaN at the border
  };
  /// Interpolates bilinearly between the centres of reduced cells. Column and row are in pixels of the file, with the
  /// centre of the first pixel at (0, 0).
  [[nodiscard]] Sample at(double column, double row);
  [[nodiscard]] double height_at(double column, double row);
  /// Whether the point lies between the centres of the outermost reduced cells.
  [[nodiscard]] bool contains(double column, double row) const;

 private:
  using Block = host::Raster<float>;
  [[nodiscard]] const Block& block(std::int32_t column, std::int32_t row);
  [[nodiscard]] Block read_block(std::int32_t column, std::int32_t row);

  host::RasterBand band_;
  std::int32_t factor_ = 1;
  // Most recently used block first.
  std::list<std::pair<std::int64_t, Block>> blocks_;
  std::unordered_map<std::int64_t, decltype(blocks_)::iterator> where_;
};

}  // namespace ilp::compare
