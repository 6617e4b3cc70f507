#include "sim/ground/export/raster_export.hpp"

#include <cpl_string.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <system_error>

#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"

namespace ilp::exports {
namespace {
namespace fs = std::filesystem;

constexpr std::uint16_t no_count = 65535;

struct BandInfo {
  const char* name;
  GDALDataType type;
  double nodata;
  std::string unit, description;
  const char* resampling;  ///< of the overviews
};

fs::path with_ending(const fs::path& path, const char* ending) {
  fs::path longer = path;
  longer += ending;
  return longer;
}

// One raster while it grows: a plain tiled file in which blocks may be written in any order and empty ones take no
// place. The cloud-optimised order, in which readers want it, can only be given to a whole.
class GrowingRaster {
 public:
  GrowingRaster(BandInfo info, const map::Mosaic& mosaic, const Georeference& place, fs::path path)
      : info_(std::move(info)), path_(std::move(path)), plain_(with_ending(path_, ".plain.part")) {
    CPLStringList options;
    options.SetNameValue("TILED", "YES");
    options.SetNameValue("SPARSE_OK", "TRUE");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    dataset_.reset(
        driver->Create(plain_.c_str(), mosaic.geometry.columns, mosaic.geometry.rows, 1, info_.type, options.List()));
    if (!dataset_) throw host::gdal_error("cannot write " + plain_.string());
    describe(mosaic, place);
  }
  ~GrowingRaster() {
    dataset_.reset();
    std::error_code ignored;
    fs::remove(plain_, ignored);
    fs::remove(cloud_part(), ignored);
  }
  GrowingRaster(const GrowingRaster&) = delete;
  GrowingRaster& operator=(const GrowingRaster&) = delete;

  template <typename T>
  void write(const map::MapTile& tile, std::vector<T>& samples, GDALDataType type) {
    const host::Raster<float>& size = tile.height;
    if (dataset_->GetRasterBand(1)->RasterIO(GF_Write, tile.column, tile.row, size.width, size.height, samples.data(),
                                             size.width, size.height, type, 0, 0, nullptr) != CE_None) {
      throw host::gdal_error("cannot write " + plain_.string());
    }
  }

  void finish() {
    add_statistics();
    CPLErrorReset();
    dataset_->FlushCache(false);
    if (CPLGetLastErrorType() == CE_Failure) throw host::gdal_error("cannot write " + plain_.string());
    CPLStringList options;
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("PREDICTOR", "YES");
    options.SetNameValue("SPARSE_OK", "YES");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    options.SetNameValue("NUM_THREADS", "ALL_CPUS");
    options.SetNameValue("OVERVIEW_RESAMPLING", info_.resampling);
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("COG");
    if (!driver) throw std::runtime_error("this GDAL writes no Cloud-Optimised GeoTIFF");
    host::Dataset cloud(
        driver->CreateCopy(cloud_part().c_str(), dataset_.get(), true, options.List(), nullptr, nullptr));
    const bool begun = cloud != nullptr;
    // What is left is written when it closes.
    cloud.reset();
    if (!begun || CPLGetLastErrorType() == CE_Failure) throw host::gdal_error("cannot write " + path_.string());
  }

  void put_in_place() { host::move_into_place(cloud_part(), path_); }

 private:
  fs::path cloud_part() const { return with_ending(path_, ".part"); }

  void describe(const map::Mosaic& mosaic, const Georeference& place) {
    std::array<double, 6> transform = geotransform(place, mosaic.geometry);
    GDALRasterBand* band = dataset_->GetRasterBand(1);
    if (dataset_->SetGeoTransform(transform.data()) != CE_None ||
        dataset_->SetProjection(place.crs.c_str()) != CE_None || band->SetNoDataValue(info_.nodata) != CE_None) {
      throw host::gdal_error("cannot write " + plain_.string());
    }
    band->SetUnitType(info_.unit.c_str());
    band->SetDescription(info_.description.c_str());
    dataset_->SetMetadataItem("TIFFTAG_SOFTWARE", "ilp-ground");
    dataset_->SetMetadataItem("TIFFTAG_IMAGEDESCRIPTION", (info_.description + "; " + place.sentence).c_str());
  }

  void add_statistics() {
    GDALRasterBand* band = dataset_->GetRasterBand(1);
    double least = 0, most = 0, mean = 0, deviation = 0;
    if (band->ComputeStatistics(false, &least, &most, &mean, &deviation, nullptr, nullptr) != CE_None) {
      throw host::gdal_error("no statistics of " + path_.string());
    }
  }

  BandInfo info_;
  fs::path path_, plain_;
  host::Dataset dataset_;
};

struct TileSamples {
  std::vector<float> height, sigma;
  std::vector<std::uint16_t> count;
  std::vector<std::uint8_t> ortho;
};

void check_size(const map::Mosaic& mosaic, const map::MapTile& tile) {
  const std::int32_t w = tile.height.width, h = tile.height.height;
  const auto fits = [&](const auto& raster) { return raster.same_size(w, h); };
  const bool inside = tile.column >= 0 && tile.row >= 0 && w > 0 && h > 0 &&
                      tile.column <= mosaic.geometry.columns - w && tile.row <= mosaic.geometry.rows - h;
  if (!inside || !fits(tile.ortho) || !fits(tile.count) || !(tile.sigma.empty() || fits(tile.sigma))) {
    throw std::logic_error("a tile that does not fit its map");
  }
}

TileSamples samples_of(const map::MapTile& tile, const Georeference& place) {
  constexpr float nothing = std::numeric_limits<float>::quiet_NaN();
  const std::size_t cells = tile.height.samples.size();
  TileSamples out{std::vector<float>(cells, nothing), std::vector<float>(cells, nothing),
                  std::vector<std::uint16_t>(cells, no_count), std::vector<std::uint8_t>(cells, 0)};
  for (std::size_t i = 0; i < cells; ++i) {
    const float z = tile.height.samples[i];
    if (!std::isfinite(z)) continue;
    out.height[i] = static_cast<float>(place.height_of(z));
    if (!tile.sigma.empty() && std::isfinite(tile.sigma.samples[i])) {
      out.sigma[i] = static_cast<float>(place.scale * tile.sigma.samples[i]);
    }
    out.count[i] = std::min<std::uint16_t>(tile.count.samples[i], no_count - 1);
    out.ortho[i] = std::max<std::uint8_t>(tile.ortho.samples[i], 1);
  }
  return out;
}

bool any_finite(const std::vector<float>& samples) {
  return std::any_of(samples.begin(), samples.end(), [](float x) { return std::isfinite(x); });
}

std::vector<BandInfo> bands(const Georeference& place) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  return {{"height", GDT_Float32, nothing, place.unit, place.height_name, "AVERAGE"},
          {"sigma", GDT_Float32, nothing, place.unit, "one sigma of the height, from matching", "AVERAGE"},
          {"count", GDT_UInt16, no_count, "keyframes", "keyframes whose surface covers the cell", "NEAREST"},
          {"ortho", GDT_Byte, 0, "grey value", "seen from above", "AVERAGE"}};
}

}  // namespace

std::vector<std::string> write_rasters(const map::Mosaic& mosaic, const Georeference& place, const std::string& suffix,
                                       const fs::path& folder) {
  const host::GdalSession gdal;
  std::vector<std::unique_ptr<GrowingRaster>> rasters;
  std::vector<std::string> names;
  for (const BandInfo& info : bands(place)) {
    names.push_back(info.name + suffix + ".tif");
    rasters.push_back(std::make_unique<GrowingRaster>(info, mosaic, place, folder / names.back()));
  }
  bool seen = false, sigma_told = false;
  for (std::int32_t row = 0; row < mosaic.tile_rows; ++row) {
    for (std::int32_t column = 0; column < mosaic.tile_columns; ++column) {
      const std::optional<map::MapTile> tile = mosaic.tile(column, row);
      if (!tile) continue;
      check_size(mosaic, *tile);
      TileSamples samples = samples_of(*tile, place);
      if (!any_finite(samples.height)) continue;
      seen = true;
      rasters[0]->write(*tile, samples.height, GDT_Float32);
      if (any_finite(samples.sigma)) {
        sigma_told = true;
        rasters[1]->write(*tile, samples.sigma, GDT_Float32);
      }
      rasters[2]->write(*tile, samples.count, GDT_UInt16);
      rasters[3]->write(*tile, samples.ortho, GDT_Byte);
    }
  }
  if (!seen) throw std::runtime_error("a map on which nothing was seen");
  if (!sigma_told) {
    std::error_code ignored;
    fs::remove(folder / names[1], ignored);
    names.erase(names.begin() + 1);
    rasters.erase(rasters.begin() + 1);
  }
  for (const auto& raster : rasters) raster->finish();
  for (const auto& raster : rasters) raster->put_in_place();
  return names;
}

host::Raster<std::uint8_t> read_ortho(const fs::path& file, std::int32_t max_side) {
  const host::GdalSession gdal;
  const host::Dataset dataset(GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  if (!dataset) throw host::gdal_error("cannot read " + file.string());
  const std::int32_t columns = dataset->GetRasterXSize(), rows = dataset->GetRasterYSize();
  const double shrink = std::max(1.0, static_cast<double>(std::max(columns, rows)) / max_side);
  const auto shrunk = [&](std::int32_t side) { return std::max(1, static_cast<std::int32_t>(side / shrink)); };
  host::Raster<std::uint8_t> texture(shrunk(columns), shrunk(rows));
  GDALRasterIOExtraArg how;
  INIT_RASTERIO_EXTRA_ARG(how);
  how.eResampleAlg = GRIORA_Average;
  if (dataset->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, columns, rows, texture.samples.data(), texture.width,
                                          texture.height, GDT_Byte, 0, 0, &how) != CE_None) {
    throw host::gdal_error("cannot read " + file.string());
  }
  return texture;
}

}  // namespace ilp::exports
