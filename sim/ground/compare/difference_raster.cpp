#include "sim/ground/compare/difference_raster.hpp"

#include <cpl_string.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/ground/compare/terrain_samples.hpp"
#include "sim/host/files.hpp"

namespace ilp::compare {
namespace {
namespace fs = std::filesystem;

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
constexpr std::int32_t overview_side = 1400;

host::Similarity3 product(const host::Similarity3& a, const host::Similarity3& b) {
  return {a.scale * b.scale, a.rotation * b.rotation, a * b.translation};
}

/// The corner and the sides of the map's pixels after the move, at its mean height.
GeoTransform moved_transform(const HeightModel& map, const host::Similarity3& moved, double height) {
  const GeoTransform& t = map.transform();
  const Vec3 corner = moved * Vec3(t[0], t[3], height), column = moved * Vec3(t[0] + t[1], t[3] + t[4], height),
             row = moved * Vec3(t[0] + t[2], t[3] + t[5], height);
  return {corner.x(), column.x() - corner.x(), row.x() - corner.x(),
          corner.y(), column.y() - corner.y(), row.y() - corner.y()};
}

/// Means of blocks of cells.
class Overview {
 public:
  explicit Overview(const HeightModel& map)
      : factor_((std::max(map.columns(), map.rows()) + overview_side - 1) / overview_side),
        height_((map.columns() + factor_ - 1) / factor_, (map.rows() + factor_ - 1) / factor_, 0.0F),
        difference_(height_.width, height_.height, 0.0F),
        heights_(height_.width, height_.height, 0),
        differences_(height_.width, height_.height, 0) {}

  void add_height(std::int32_t column, std::int32_t row, double height) {
    add(height_, heights_, height_.index(column / factor_, row / factor_), height);
  }
  void add_difference(std::int32_t column, std::int32_t row, double difference) {
    add(difference_, differences_, height_.index(column / factor_, row / factor_), difference);
  }
  DifferenceOverview means(double cell) {
    divide(height_, heights_);
    divide(difference_, differences_);
    return {std::move(height_), std::move(difference_), cell * factor_};
  }

 private:
  using Counts = host::Raster<std::uint32_t>;
  static void add(host::Raster<float>& sums, Counts& counts, std::size_t at, double value) {
    sums.samples[at] += static_cast<float>(value);
    ++counts.samples[at];
  }
  static void divide(host::Raster<float>& sums, const Counts& counts) {
    for (std::size_t i = 0; i < counts.samples.size(); ++i) {
      sums.samples[i] = counts.samples[i] > 0 ? sums.samples[i] / static_cast<float>(counts.samples[i]) : nothing;
    }
  }

  std::int32_t factor_;
  host::Raster<float> height_, difference_;
  Counts heights_, differences_;
};

class DifferenceWriter {
 public:
  DifferenceWriter(HeightModel& map, const EstimatedErrors& stated, HeightModel& other, const ModelFrames& frames,
                   const host::Similarity3& moved, double max_slope_rad)
      : map_(map),
        stated_(stated),
        other_(other),
        frames_(frames),
        moved_(product(moved, frames.common_from_map())),
        steepest_(std::tan(max_slope_rad)),
        cell_(side_of_pixel(map) * moved_.scale),
        overview_(map) {}

  DifferenceResult write(const fs::path& path) {
    fs::path part = path;
    part += ".part";
    create(part);
    for (std::int32_t y = 0; y < map_.rows(); y += block_side) {
      for (std::int32_t x = 0; x < map_.columns(); x += block_side) write_block(x, y);
    }
    finish(part);
    host::move_into_place(part, path);
    return {counts_, overview_.means(cell_), other_cell_};
  }

 private:
  void create(const fs::path& part) {
    CPLStringList options;
    options.SetNameValue("TILED", "YES");
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("PREDICTOR", "3");
    options.SetNameValue("SPARSE_OK", "TRUE");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    file_.reset(driver->Create(part.c_str(), map_.columns(), map_.rows(), 1, GDT_Float32, options.List()));
    if (!file_) throw host::gdal_error("cannot write " + part.string());
    GDALRasterBand& band = *file_->GetRasterBand(1);
    band.SetNoDataValue(nothing);
    band.SetUnitType("metre");
    band.SetDescription("height of the map minus height of the other model");
    file_->SetMetadataItem("TIFFTAG_SOFTWARE", "ilp-ground compare");
    if (!frames_.system().empty()) file_->SetProjection(frames_.system().c_str());
  }

  void write_block(std::int32_t x0, std::int32_t y0) {
    host::Raster<float> block(std::min(block_side, map_.columns() - x0), std::min(block_side, map_.rows() - y0),
                              nothing);
    std::vector<Cell> cells;
    std::vector<double> x, y;
    for (std::int32_t j = 0; j < block.height; ++j) {
      for (std::int32_t i = 0; i < block.width; ++i) {
        const float height = map_.cell(x0 + i, y0 + j);
        if (!std::isfinite(height)) {
          ++counts_.without_height;
          continue;
        }
        const Vec3 place = moved_ * map_point(map_, x0 + i, y0 + j, double{height});
        cells.push_back({i, j, place.z()});
        x.push_back(place.x());
        y.push_back(place.y());
      }
    }
    if (cells.empty()) return;
    const PixelScale scale = pixel_scale(frames_, x[x.size() / 2], y[y.size() / 2], cell_);
    if (other_cell_ == 0 && std::isfinite(scale.pixel())) other_cell_ = scale.pixel() * other_.factor();
    frames_.to_pixels(x, y);
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const Cell& cell = cells[k];
      const std::int32_t column = x0 + cell.column, row = y0 + cell.row;
      overview_.add_height(column, row, cell.height);
      sum_of_heights_ += double{map_.cell(column, row)};
      ++heights_;
      const double difference = difference_at(cell.height, x[k], y[k], scale);
      if (!std::isfinite(difference)) continue;
      block.at(cell.column, cell.row) = static_cast<float>(difference);
      overview_.add_difference(column, row, difference);
      count_within(stated_.sigma, column, row, difference, counts_.sigma);
      count_within(stated_.matching, column, row, difference, counts_.matching);
    }
    if (file_->GetRasterBand(1)->RasterIO(GF_Write, x0, y0, block.width, block.height, block.samples.data(),
                                          block.width, block.height, GDT_Float32, 0, 0, nullptr) != CE_None) {
      throw host::gdal_error(std::string("cannot write ") + file_->GetDescription());
    }
  }

  double difference_at(double height, double column, double row, const PixelScale& scale) {
    if (!(std::isfinite(column) && std::isfinite(row)) || !other_.contains(column, row)) {
      ++counts_.outside;
      return unknown;
    }
    const HeightModel::Sample there = other_.at(column, row);
    if (!std::isfinite(there.height)) {
      ++counts_.without_other;
      return unknown;
    }
    const double slope = std::hypot(there.per_column * scale.column_x + there.per_row * scale.row_x,
                                    there.per_column * scale.column_y + there.per_row * scale.row_y);
    // At the border of the other model the slope is not known, and the cell stays.
    if (slope > steepest_) {
      ++counts_.steep;
      return unknown;
    }
    ++counts_.compared;
    return height - there.height;
  }

  void count_within(HeightModel* stated, std::int32_t column, std::int32_t row, double difference,
                    CellCounts::Within& counts) const {
    const double sigma = stated != nullptr ? moved_.scale * double{stated->cell(column, row)} : unknown;
    if (!(sigma > 0)) return;
    ++counts.stated;
    if (std::fabs(difference) <= sigma) ++counts.one;
    if (std::fabs(difference) <= 2 * sigma) ++counts.two;
  }

  void finish(const fs::path& part) {
    GeoTransform transform =
        moved_transform(map_, moved_, heights_ > 0 ? sum_of_heights_ / static_cast<double>(heights_) : 0);
    file_->SetGeoTransform(transform.data());
    CPLErrorReset();
    file_.reset();
    if (CPLGetLastErrorType() == CE_Failure) throw host::gdal_error("cannot write " + part.string());
  }

  struct Cell {
    std::int32_t column = 0, row = 0;
    double height = 0;
  };
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  HeightModel& map_;
  EstimatedErrors stated_;
  HeightModel& other_;
  const ModelFrames& frames_;
  host::Similarity3 moved_;
  double steepest_, cell_;
  Overview overview_;
  CellCounts counts_;
  host::Dataset file_;
  double sum_of_heights_ = 0, other_cell_ = 0;
  std::uint64_t heights_ = 0;
};

}  // namespace

DifferenceResult write_difference(HeightModel& map, const EstimatedErrors& stated, HeightModel& other,
                                  const ModelFrames& frames, const host::Similarity3& moved, double max_slope_rad,
                                  const fs::path& path) {
  return DifferenceWriter(map, stated, other, frames, moved, max_slope_rad).write(path);
}

}  // namespace ilp::compare
