#include "sim/host/photograph.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "sim/host/exif.hpp"
#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/text_format.hpp"

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
  const int width = dataset->GetRasterXSize(), height = dataset->GetRasterYSize();
  if (is_too_large(width, height))
    throw TooLargePhotograph(path.string() + ": " + size_text(width, height) +
                             " pixels are too many: scale it down to " + std::to_string(most_image_pixels >> 20U) +
                             " million pixels at most, and its camera with it");
  const int bands = dataset->GetRasterCount();
  if (bands < 1 || bands > 4) refuse(path, std::to_string(bands) + " bands, expected grey or colour");
  const GDALDataType type = dataset->GetRasterBand(1)->GetRasterDataType();
  if (type != GDT_Byte && type != GDT_UInt16)
    refuse(path, std::string("samples of the type ") + GDALGetDataTypeName(type) + ": convert it to 8 or 16 bits");
  return dataset;
}

/// What a decoder says about data that are cut off or damaged. It is only a warning to libjpeg, which fills the rest
/// with grey; some cameras leave a few octets between segments, which harm nothing.
class Complaints {
 public:
  Complaints() { CPLPushErrorHandlerEx(keep, &first_); }
  ~Complaints() { CPLPopErrorHandler(); }
  Complaints(const Complaints&) = delete;
  Complaints& operator=(const Complaints&) = delete;
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  static void keep(CPLErr kind, CPLErrorNum, const char* message) {
    auto& first = *static_cast<std::string*>(CPLGetErrorHandlerUserData());
    if (first.empty() && kind >= CE_Warning && std::strstr(message, "extraneous bytes") == nullptr) first = message;
  }
  std::string first_;
};

using Samples = std::vector<std::uint16_t>;

Samples samples_of(GDALDataset& dataset, int band, const fs::path& path) {
  const int width = dataset.GetRasterXSize(), height = dataset.GetRasterYSize();
  Samples samples(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const Complaints complaints;
  const CPLErr done = dataset.GetRasterBand(band)->RasterIO(GF_Read, 0, 0, width, height, samples.data(), width, height,
                                                            GDT_UInt16, 0, 0, nullptr);
  const bool jpeg = std::strcmp(dataset.GetDriver()->GetDescription(), "JPEG") == 0;
  if (done != CE_None || (jpeg && !complaints.first().empty()))
    throw DamagedPhotograph(
        path.string() + ": damaged image: " + complaints.first().substr(0, complaints.first().find(" (this warning")));
  return samples;
}

/// Red, green and blue; three times the same where the file has grey values only.
struct Bands {
  Samples red, green, blue;
  bool coloured = false;
};

Bands bands_of(GDALDataset& dataset, const fs::path& path) {
  Bands bands;
  bands.red = samples_of(dataset, 1, path);
  const GDALColorTable* const table = dataset.GetRasterBand(1)->GetColorTable();
  bands.coloured = table != nullptr || dataset.GetRasterCount() >= 3;
  if (table != nullptr) {
    bands.green = bands.blue = bands.red;
    for (std::size_t i = 0; i < bands.red.size(); ++i) {
      GDALColorEntry colour{};
      if (bands.red[i] < table->GetColorEntryCount()) table->GetColorEntryAsRGB(bands.red[i], &colour);
      bands.red[i] = static_cast<std::uint16_t>(colour.c1);
      bands.green[i] = static_cast<std::uint16_t>(colour.c2);
      bands.blue[i] = static_cast<std::uint16_t>(colour.c3);
    }
  } else if (bands.coloured) {
    bands.green = samples_of(dataset, 2, path);
    bands.blue = samples_of(dataset, 3, path);
  }
  return bands;
}

/// Whether the file goes on to the end of its image (ITU-T T.81, B.1.1): a part that was lost may be zeros, in which a
/// decoder finds pixels. What follows the end does not matter.
bool jpeg_ends(const fs::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  constexpr std::uint8_t scan = 0xDA, end = 0xD9, first_restart = 0xD0, last_restart = 0xD7;
  std::size_t at = 2;
  while (at + 4 <= bytes.size()) {
    if (bytes[at] != 0xFF) return false;
    const std::uint8_t marker = bytes[at + 1];
    if (marker == end) return true;
    if (marker == 0xFF) {
      ++at;
      continue;
    }
    at += 2 + static_cast<std::size_t>(bytes[at + 2] << 8U | bytes[at + 3]);
    if (marker != scan) continue;
    // Behind the header of a scan: data, up to a marker that is neither a stuffed octet nor a restart.
    while (at + 1 < bytes.size() && (bytes[at] != 0xFF || bytes[at + 1] == 0 || bytes[at + 1] == 0xFF ||
                                     (bytes[at + 1] >= first_restart && bytes[at + 1] <= last_restart)))
      ++at;
  }
  return at + 1 < bytes.size() && bytes[at] == 0xFF && bytes[at + 1] == end;
}

void require_whole(GDALDataset& dataset, const fs::path& path) {
  if (std::strcmp(dataset.GetDriver()->GetDescription(), "JPEG") == 0 && !jpeg_ends(path))
    throw DamagedPhotograph(path.string() + ": damaged image: the JPEG data have no end");
}

bool is_deep(GDALDataset& dataset) {
  GDALRasterBand& band = *dataset.GetRasterBand(1);
  return band.GetRasterDataType() == GDT_UInt16 && band.GetColorTable() == nullptr;
}

Photograph read_grey(const fs::path& path) {
  const Dataset dataset = open(path);
  Photograph photograph;
  photograph.deep = is_deep(*dataset);
  photograph.grey = Raster<std::uint16_t>(dataset->GetRasterXSize(), dataset->GetRasterYSize());
  require_whole(*dataset, path);
  Bands bands = bands_of(*dataset, path);
  if (!bands.coloured) {
    photograph.grey.samples = std::move(bands.red);
    return photograph;
  }
  for (std::size_t i = 0; i < bands.red.size(); ++i) {
    photograph.grey.samples[i] =
        static_cast<std::uint16_t>(std::lround(0.299 * bands.red[i] + 0.587 * bands.green[i] + 0.114 * bands.blue[i]));
  }
  return photograph;
}

}  // namespace

Photograph read_photograph(const fs::path& path) {
  const GdalSession session(register_formats);
  try {
    return read_grey(path);
  } catch (const std::bad_alloc&) {
    throw TooLargePhotograph(path.string() +
                             ": this machine has not enough memory for so many pixels: scale it down, " +
                             "and its camera with it");
  }
}

Raster<Rgb> read_colours(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  const bool deep = is_deep(*dataset);
  const auto octet = [deep](std::uint16_t value) { return static_cast<std::uint8_t>(deep ? value / 257 : value); };
  const Bands bands = bands_of(*dataset, path);
  const Samples& green = bands.coloured ? bands.green : bands.red;
  const Samples& blue = bands.coloured ? bands.blue : bands.red;
  Raster<Rgb> colours(dataset->GetRasterXSize(), dataset->GetRasterYSize());
  for (std::size_t i = 0; i < bands.red.size(); ++i)
    colours.samples[i] = {octet(bands.red[i]), octet(green[i]), octet(blue[i])};
  return colours;
}

PhotographFacts read_photograph_facts(const fs::path& path) {
  const GdalSession session(register_formats);
  const Dataset dataset = open(path);
  PhotographFacts facts;
  facts.width = dataset->GetRasterXSize();
  facts.height = dataset->GetRasterYSize();
  facts.deep = is_deep(*dataset);
  read_exif(path, facts);
  return facts;
}

}  // namespace ilp::host
