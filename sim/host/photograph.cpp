#include "sim/host/photograph.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "sim/host/gdal_session.hpp"

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

// Only these: other drivers use SQLite as soon as they are registered, and the flight configures it first.
void register_formats() {
  GDALRegister_GTiff();
  GDALRegister_JPEG();
  GDALRegister_PNG();
  GDALRegister_PNM();
}

[[noreturn]] void refuse(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

Dataset open(const fs::path& path) {
  Dataset dataset(GDALDataset::FromHandle(GDALOpenEx(path.c_str(), GDAL_OF_RASTER, nullptr, nullptr, nullptr)));
  if (!dataset) throw gdal_error(path.string() + ": no JPEG, TIFF, PNG or PGM image");
  const int bands = dataset->GetRasterCount();
  if (bands < 1 || bands > 4) refuse(path, std::to_string(bands) + " bands, expected grey or colour");
  const GDALDataType type = dataset->GetRasterBand(1)->GetRasterDataType();
  if (type != GDT_Byte && type != GDT_UInt16)
    refuse(path, std::string("samples of the type ") + GDALGetDataTypeName(type) + ": convert it to 8 or 16 bits");
  if (dataset->GetRasterBand(1)->GetColorTable() != nullptr)
    refuse(path, "the image has a colour table: convert it to grey or to colours");
  return dataset;
}

std::optional<std::string> exif(GDALDataset& dataset, const char* name) {
  for (const char* domain : {"", "EXIF"}) {
    const char* const text = dataset.GetMetadataItem(name, domain);
    if (text != nullptr) return text;
  }
  return std::nullopt;
}

std::optional<double> exif_number(GDALDataset& dataset, const char* name) {
  const auto text = exif(dataset, name);
  double value = 0;
  if (!text || (std::sscanf(text->c_str(), " ( %lf", &value) != 1 && std::sscanf(text->c_str(), "%lf", &value) != 1))
    return std::nullopt;
  return value;
}

std::optional<double> field_of_view(GDALDataset& dataset) {
  constexpr double film_width_mm = 36;
  const auto focal_mm = exif_number(dataset, "EXIF_FocalLengthIn35mmFilm");
  if (!focal_mm || *focal_mm < 4 || *focal_mm > 2000) return std::nullopt;
  // The longer side of the image is that of the film.
  const double width = dataset.GetRasterXSize(), longer = std::max(width, double(dataset.GetRasterYSize()));
  return 2 * std::atan(0.5 * film_width_mm * width / longer / *focal_mm);
}

std::optional<std::int64_t> exposure_time(GDALDataset& dataset) {
  const auto text = exif(dataset, "EXIF_DateTimeOriginal");
  std::tm tm{};
  if (!text || std::sscanf(text->c_str(), "%d:%d:%d %d:%d:%d", &tm.tm_year, &tm.tm_mon, &tm.tm_mday, &tm.tm_hour,
                           &tm.tm_min, &tm.tm_sec) != 6)
    return std::nullopt;
  tm.tm_year -= 1900;
  tm.tm_mon -= 1;
  std::int64_t time_ns = std::int64_t{timegm(&tm)} * 1'000'000'000;
  // Digits of a fraction of the second.
  const auto part = exif(dataset, "EXIF_SubSecTimeOriginal");
  std::int64_t unit = 100'000'000;
  for (const char c : part.value_or("")) {
    if (c < '0' || c > '9' || unit == 0) break;
    time_ns += (c - '0') * unit;
    unit /= 10;
  }
  return time_ns;
}

std::vector<std::uint16_t> samples_of(GDALDataset& dataset, int band, const fs::path& path) {
  const int width = dataset.GetRasterXSize(), height = dataset.GetRasterYSize();
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  if (dataset.GetRasterBand(band)->RasterIO(GF_Read, 0, 0, width, height, samples.data(), width, height, GDT_UInt16, 0,
                                            0, nullptr) != CE_None) {
    throw gdal_error(path.string() + ": damaged image");
  }
  return samples;
}

}  // namespace

Photograph read_photograph(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  Photograph photograph;
  photograph.deep = dataset->GetRasterBand(1)->GetRasterDataType() == GDT_UInt16;
  photograph.grey = Raster<std::uint16_t>(dataset->GetRasterXSize(), dataset->GetRasterYSize());
  if (dataset->GetRasterCount() < 3) {
    photograph.grey.samples = samples_of(*dataset, 1, path);
    return photograph;
  }
  const auto red = samples_of(*dataset, 1, path), green = samples_of(*dataset, 2, path),
             blue = samples_of(*dataset, 3, path);
  for (std::size_t i = 0; i < red.size(); ++i) {
    photograph.grey.samples[i] =
        static_cast<std::uint16_t>(std::lround(0.299 * red[i] + 0.587 * green[i] + 0.114 * blue[i]));
  }
  return photograph;
}

PhotographFacts read_photograph_facts(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  PhotographFacts facts;
  facts.width = dataset->GetRasterXSize();
  facts.height = dataset->GetRasterYSize();
  facts.deep = dataset->GetRasterBand(1)->GetRasterDataType() == GDT_UInt16;
  facts.field_of_view_rad = field_of_view(*dataset);
  facts.time_ns = exposure_time(*dataset);
  return facts;
}

}  // namespace ilp::host
