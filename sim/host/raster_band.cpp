#include "sim/host/raster_band.hpp"

#include <limits>
#include <stdexcept>

#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace {

constexpr float missing_value = std::numeric_limits<float>::quiet_NaN();

[[noreturn]] void refuse_raster(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

/// Numbers of brightness count as they stand, but for scale and offset.
HeightUnits brightness_units(GDALRasterBand& band) {
  HeightUnits units;
  units.metres = band.GetScale();
  units.offset_m = band.GetOffset();
  units.plain = false;
  int declared = 0;
  units.missing = static_cast<float>(band.GetNoDataValue(&declared));
  units.missing_declared = declared != 0;
  return units;
}

}  // namespace

RasterBand::RasterBand(std::filesystem::path path, Content content) : path_(std::move(path)) {
  std::error_code ignored;
  if (!std::filesystem::exists(path_, ignored)) refuse_raster(path_, "there is no such file; check the path");
  dataset_.reset(GDALDataset::Open(path_.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset_) throw gdal_error(path_.string() + ": not a raster that GDAL reads");
  if (dataset_->GetRasterCount() != 1) {
    refuse_raster(path_, counted(static_cast<std::size_t>(dataset_->GetRasterCount()), "band") + ", one with " +
                             (content == Content::heights ? "heights" : "brightness") +
                             " expected (gdal_translate -b 1 takes one out)");
  }
  columns_ = dataset_->GetRasterXSize();
  rows_ = dataset_->GetRasterYSize();
  if (columns_ < 2 || rows_ < 2) {
    refuse_raster(path_, "a raster of " + size_text(columns_, rows_) + " pixels; at least 2x2 expected");
  }
  if (dataset_->GetGeoTransform(transform_.data()) != CE_None) {
    refuse_raster(path_, "the file does not say where its pixels are (gdal_translate -a_ullr states it)");
  }
  if (transform_[1] * transform_[5] - transform_[2] * transform_[4] == 0) refuse_raster(path_, "pixels of no size");
  GDALRasterBand& band = *dataset_->GetRasterBand(1);
  units_ = content == Content::heights ? height_units(path_, *dataset_) : brightness_units(band);
  masked_ = (band.GetMaskFlags() & GMF_PER_DATASET) != 0;
}

const OGRSpatialReference* RasterBand::system() const {
  const OGRSpatialReference* const system = dataset_->GetSpatialRef();
  return system != nullptr && system->IsEmpty() == 0 ? system : nullptr;
}

void RasterBand::clear_missing(Raster<float>& block, std::int32_t x, std::int32_t y, std::int32_t width,
                               std::int32_t height) {
  GDALRasterBand& band = *dataset_->GetRasterBand(1);
  Raster<std::uint8_t> mask;
  if (masked_) {
    mask = Raster<std::uint8_t>(block.width, block.height);
    if (band.GetMaskBand()->RasterIO(GF_Read, x, y, width, height, mask.samples.data(), mask.width, mask.height,
                                     GDT_Byte, 0, 0, nullptr) != CE_None) {
      throw gdal_error(path_.string() + ": cannot be read");
    }
  }
  for (std::size_t i = 0; i < block.samples.size(); ++i) {
    float& value = block.samples[i];
    const bool none = units_.is_missing(value) || (masked_ && mask.samples[i] == 0);
    value = none ? missing_value : static_cast<float>(units_.metres * double{value} + units_.offset_m);
  }
}

/// Means of pixels whose missing values GDAL does not know, row of cells by row of cells.
void RasterBand::average(Raster<float>& block, std::int32_t x, std::int32_t y, std::int32_t factor) {
  Raster<float> strip(block.width * factor, factor);
  for (std::int32_t row = 0; row < block.height; ++row) {
    if (dataset_->GetRasterBand(1)->RasterIO(GF_Read, x, y + row * factor, strip.width, strip.height,
                                             strip.samples.data(), strip.width, strip.height, GDT_Float32, 0, 0,
                                             nullptr) != CE_None)
      throw gdal_error(path_.string() + ": cannot be read");
    for (std::int32_t column = 0; column < block.width; ++column) {
      double sum = 0;
      std::int32_t count = 0;
      for (std::int32_t v = 0; v < factor; ++v) {
        for (std::int32_t u = 0; u < factor; ++u) {
          const float value = strip.at(column * factor + u, v);
          if (units_.is_missing(value)) continue;
          sum += double{value};
          ++count;
        }
      }
      block.at(column, row) = count > 0 ? static_cast<float>(sum / count) : missing_value;
    }
  }
}

Raster<float> RasterBand::read(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                               std::int32_t factor) {
  Raster<float> block(width, height);
  if (factor > 1 && !units_.missing_declared && !masked_) {
    average(block, x, y, factor);
    clear_missing(block, x, y, width * factor, height * factor);
    return block;
  }
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = factor > 1 ? GRIORA_Average : GRIORA_NearestNeighbour;
  if (dataset_->GetRasterBand(1)->RasterIO(GF_Read, x, y, width * factor, height * factor, block.samples.data(), width,
                                           height, GDT_Float32, 0, 0, &how) != CE_None) {
    throw gdal_error(path_.string() + ": cannot be read");
  }
  clear_missing(block, x, y, width * factor, height * factor);
  return block;
}

}  // namespace ilp::host
