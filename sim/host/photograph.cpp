#include "sim/host/photograph.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <string>
#include <vector>

#include "sim/host/exif.hpp"
#include "sim/host/files.hpp"
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
  if (::access(path.c_str(), R_OK) != 0) refuse(path, "cannot be read: " + read_failure(errno));
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

Raster<Rgb> read_colours(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  const bool deep = dataset->GetRasterBand(1)->GetRasterDataType() == GDT_UInt16;
  const auto octet = [deep](std::uint16_t value) { return static_cast<std::uint8_t>(deep ? value / 257 : value); };
  const bool coloured = dataset->GetRasterCount() >= 3;
  const auto red = samples_of(*dataset, 1, path);
  const auto green = coloured ? samples_of(*dataset, 2, path) : red;
  const auto blue = coloured ? samples_of(*dataset, 3, path) : red;
  Raster<Rgb> colours(dataset->GetRasterXSize(), dataset->GetRasterYSize());
  for (std::size_t i = 0; i < red.size(); ++i) colours.samples[i] = {octet(red[i]), octet(green[i]), octet(blue[i])};
  return colours;
}

PhotographFacts read_photograph_facts(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  PhotographFacts facts;
  facts.width = dataset->GetRasterXSize();
  facts.height = dataset->GetRasterYSize();
  facts.deep = dataset->GetRasterBand(1)->GetRasterDataType() == GDT_UInt16;
  read_exif(path, facts);
  return facts;
}

}  // namespace ilp::host
