#include "sim/ground/compare/height_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/host/text_format.hpp"

namespace ilp::compare {
namespace {

constexpr float missing_height = std::numeric_limits<float>::quiet_NaN();
constexpr std::size_t most_blocks = 64;

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

}  // namespace

HeightModel::HeightModel(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) refuse(path_, "there is no such file; check the path");
  dataset_.reset(GDALDataset::Open(path_.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset_) throw host::gdal_error(path_.string() + ": not a raster that GDAL reads");
  if (dataset_->GetRasterCount() != 1) {
    refuse(path_, host::counted(static_cast<std::size_t>(dataset_->GetRasterCount()), "band") +
                      ", one with heights expected (gdal_translate -b 1 takes one out)");
  }
  columns_ = dataset_->GetRasterXSize();
  rows_ = dataset_->GetRasterYSize();
  if (columns_ < 2 || rows_ < 2) {
    refuse(path_, "a raster of " + host::size_text(columns_, rows_) + " pixels; at least 2x2 expected");
  }
  if (dataset_->GetGeoTransform(transform_.data()) != CE_None) {
    refuse(path_, "the file does not say where its pixels are (gdal_translate -a_ullr states it)");
  }
  if (transform_[1] * transform_[5] - transform_[2] * transform_[4] == 0) refuse(path_, "pixels of no size");
  GDALRasterBand& band = *dataset_->GetRasterBand(1);
  units_ = host::height_units(path_, *dataset_);
  masked_ = (band.GetMaskFlags() & GMF_PER_DATASET) != 0;
}

const OGRSpatialReference* HeightModel::system() const {
  const OGRSpatialReference* const system = dataset_->GetSpatialRef();
  return system != nullptr && system->IsEmpty() == 0 ? system : nullptr;
}

void HeightModel::reduce(std::int32_t factor) {
  factor = std::clamp(factor, 1, std::min(columns_, rows_) / 2);
  if (factor == factor_) return;
  factor_ = factor;
  blocks_.clear();
  where_.clear();
}

void HeightModel::clear_missing(Block& block, std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height) {
  GDALRasterBand& band = *dataset_->GetRasterBand(1);
  host::Raster<std::uint8_t> mask;
  if (masked_) {
    mask = host::Raster<std::uint8_t>(block.width, block.height);
    if (band.GetMaskBand()->RasterIO(GF_Read, x, y, width, height, mask.samples.data(), mask.width, mask.height,
                                     GDT_Byte, 0, 0, nullptr) != CE_None) {
      throw host::gdal_error(path_.string() + ": cannot be read");
    }
  }
  for (std::size_t i = 0; i < block.samples.size(); ++i) {
    float& value = block.samples[i];
    const bool none = units_.is_missing(value) || (masked_ && mask.samples[i] == 0);
    value = none ? missing_height : static_cast<float>(units_.metres * double{value} + units_.offset_m);
  }
}

/// Means of pixels whose missing values GDAL does not know, row of cells by row of cells.
void HeightModel::average(Block& block, std::int32_t x, std::int32_t y) {
  host::Raster<float> strip(block.width * factor_, factor_);
  for (std::int32_t row = 0; row < block.height; ++row) {
    if (dataset_->GetRasterBand(1)->RasterIO(GF_Read, x, y + row * factor_, strip.width, strip.height,
                                             strip.samples.data(), strip.width, strip.height, GDT_Float32, 0, 0,
                                             nullptr) != CE_None)
      throw host::gdal_error(path_.string() + ": cannot be read");
    for (std::int32_t column = 0; column < block.width; ++column) {
      double sum = 0;
      std::int32_t count = 0;
      for (std::int32_t v = 0; v < factor_; ++v) {
        for (std::int32_t u = 0; u < factor_; ++u) {
          const float value = strip.at(column * factor_ + u, v);
          if (units_.is_missing(value)) continue;
          sum += double{value};
          ++count;
        }
      }
      block.at(column, row) = count > 0 ? static_cast<float>(sum / count) : missing_height;
    }
  }
}

HeightModel::Block HeightModel::read_block(std::int32_t column, std::int32_t row) {
  const std::int32_t x = column * block_side, y = row * block_side;
  Block block(std::min(block_side, reduced_columns() - x), std::min(block_side, reduced_rows() - y));
  if (factor_ > 1 && !units_.missing_declared && !masked_) {
    average(block, x * factor_, y * factor_);
    clear_missing(block, x * factor_, y * factor_, block.width * factor_, block.height * factor_);
    return block;
  }
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = factor_ > 1 ? GRIORA_Average : GRIORA_NearestNeighbour;
  const std::int32_t width = block.width * factor_, height = block.height * factor_;
  if (dataset_->GetRasterBand(1)->RasterIO(GF_Read, x * factor_, y * factor_, width, height, block.samples.data(),
                                           block.width, block.height, GDT_Float32, 0, 0, &how) != CE_None) {
    throw host::gdal_error(path_.string() + ": cannot be read");
  }
  clear_missing(block, x * factor_, y * factor_, width, height);
  return block;
}

const HeightModel::Block& HeightModel::block(std::int32_t column, std::int32_t row) {
  const std::int64_t key = (std::int64_t{row} << 32) + column;
  if (!blocks_.empty() && blocks_.front().first == key) return blocks_.front().second;
  const auto known = where_.find(key);
  if (known != where_.end()) {
    blocks_.splice(blocks_.begin(), blocks_, known->second);
    return blocks_.front().second;
  }
  if (blocks_.size() >= most_blocks) {
    where_.erase(blocks_.back().first);
    blocks_.pop_back();
  }
  blocks_.emplace_front(key, read_block(column, row));
  where_[key] = blocks_.begin();
  return blocks_.front().second;
}

float HeightModel::cell(std::int32_t column, std::int32_t row) {
  return block(column / block_side, row / block_side).at(column % block_side, row % block_side);
}

bool HeightModel::contains(double column, double row) const {
  const double i = (column + 0.5) / factor_ - 0.5, j = (row + 0.5) / factor_ - 0.5;
  return i >= 0 && j >= 0 && i <= reduced_columns() - 1 && j <= reduced_rows() - 1;
}

double HeightModel::height_at(double column, double row) {
  if (!contains(column, row)) return missing_height;
  const double x = (column + 0.5) / factor_ - 0.5, y = (row + 0.5) / factor_ - 0.5;
  const std::int32_t i = std::min(static_cast<std::int32_t>(x), reduced_columns() - 2);
  const std::int32_t j = std::min(static_cast<std::int32_t>(y), reduced_rows() - 2);
  const double u = x - i, v = y - j;
  return (1 - v) * ((1 - u) * double{cell(i, j)} + u * double{cell(i + 1, j)}) +
         v * ((1 - u) * double{cell(i, j + 1)} + u * double{cell(i + 1, j + 1)});
}

HeightModel::Sample HeightModel::at(double column, double row) {
  // Over two cells, so that noise of the model's own weighs less.
  const double step = factor_;
  Sample sample;
  sample.height = height_at(column, row);
  if (!std::isfinite(sample.height)) return sample;
  sample.per_column = (height_at(column + step, row) - height_at(column - step, row)) / (2 * step);
  sample.per_row = (height_at(column, row + step) - height_at(column, row - step)) / (2 * step);
  return sample;
}

}  // namespace ilp::compare
