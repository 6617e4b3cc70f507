#include "sim/host/geotiff.hpp"

#include <geotiff.h>
#include <geotiffio.h>
#include <geovalues.h>
#include <tiffio.h>
#include <xtiffio.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

constexpr std::uint32_t largest_side = 32768;
constexpr std::uint64_t most_pixels = std::uint64_t{1} << 28U;
constexpr std::uint32_t most_bytes = 1U << 30U;  // of one strip or tile: a short file must not cost gigabytes
constexpr ttag_t gdal_nodata = 42113;

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

TIFFExtendProc earlier_extender = nullptr;

void add_nodata_tag(TIFF* tiff) {
  static char name[] = "GDAL_NODATA";
  static const TIFFFieldInfo field = {gdal_nodata, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, name};
  TIFFMergeFieldInfo(tiff, &field, 1);
  if (earlier_extender != nullptr) earlier_extender(tiff);
}

/// Makes the tags of GeoTIFF and of GDAL known to libtiff, once.
void register_tags() {
  static std::once_flag once;
  std::call_once(once, [] {
    XTIFFInitialize();
    earlier_extender = TIFFSetTagExtender(add_nodata_tag);
  });
}

int keep_message(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  char text[256];
  std::vsnprintf(text, sizeof(text), format, arguments);
  auto& message = *static_cast<std::string*>(user);
  if (message.empty()) message = text;
  return 1;
}

/// To libtiff a tag cut off by the file's end is a warning. Unknown tags are a warning too, but no error of the file.
int keep_lost_tags(TIFF* tiff, void* user, const char* module, const char* format, va_list arguments) {
  const bool lost = std::strstr(format, "tag ignored") != nullptr;
  return lost ? keep_message(tiff, user, module, format, arguments) : 1;
}

struct CloseTiff {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
struct FreeGeo {
  void operator()(GTIF* geo) const { GTIFFree(geo); }
};
using Geo = std::unique_ptr<GTIF, FreeGeo>;

class Tiff {
 public:
  Tiff(const fs::path& path, const char* mode) : path_(path), message_(std::make_unique<std::string>()) {
    register_tags();
    const std::unique_ptr<TIFFOpenOptions, decltype(&TIFFOpenOptionsFree)> options(TIFFOpenOptionsAlloc(),
                                                                                   TIFFOpenOptionsFree);
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), keep_message, message_.get());
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), keep_lost_tags, message_.get());
    TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), most_bytes);
    tiff_.reset(TIFFOpenExt(path.c_str(), mode, options.get()));
    if (!tiff_) failed(mode[0] == 'r' ? "damaged TIFF" : "cannot be written");
  }

  [[nodiscard]] TIFF* get() const { return tiff_.get(); }
  void close() { tiff_.reset(); }
  [[nodiscard]] const std::string& message() const { return *message_; }
  [[noreturn]] void failed(const std::string& what) const {
    fail(path_, message_->empty() ? what : what + ": " + *message_);
  }

  template <typename T>
  [[nodiscard]] T tag(ttag_t which, T otherwise) const {
    T value = otherwise;
    return TIFFGetFieldDefaulted(tiff_.get(), which, &value) == 1 ? value : otherwise;
  }
  [[nodiscard]] std::vector<double> numbers(ttag_t which) const {
    std::uint16_t count = 0;
    double* values = nullptr;
    if (TIFFGetField(tiff_.get(), which, &count, &values) != 1) return {};
    return {values, values + count};
  }

 private:
  fs::path path_;
  std::unique_ptr<std::string> message_;  // libtiff keeps its address
  std::unique_ptr<TIFF, CloseTiff> tiff_;
};

template <typename T>
void widen(const std::uint8_t* bytes, std::size_t count, double* out) {
  for (std::size_t k = 0; k < count; ++k) {
    T value;
    std::memcpy(&value, bytes + k * sizeof(T), sizeof(T));
    out[k] = static_cast<double>(value);
  }
}

using Widen = void (*)(const std::uint8_t*, std::size_t, double*);

Widen widener(std::uint16_t format, std::uint16_t bits) {
  const bool whole = format == SAMPLEFORMAT_UINT || format == SAMPLEFORMAT_VOID;
  if (whole && bits == 8) return widen<std::uint8_t>;
  if (whole && bits == 16) return widen<std::uint16_t>;
  if (whole && bits == 32) return widen<std::uint32_t>;
  if (format == SAMPLEFORMAT_INT && bits == 8) return widen<std::int8_t>;
  if (format == SAMPLEFORMAT_INT && bits == 16) return widen<std::int16_t>;
  if (format == SAMPLEFORMAT_INT && bits == 32) return widen<std::int32_t>;
  if (format == SAMPLEFORMAT_IEEEFP && bits == 32) return widen<float>;
  if (format == SAMPLEFORMAT_IEEEFP && bits == 64) return widen<double>;
  return nullptr;
}

/// The value that stands for none; not a number where there is no such value.
double missing_value(const fs::path& path, const Tiff& tiff) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const char* text = nullptr;
  if (TIFFGetField(tiff.get(), gdal_nodata, &text) != 1 || text == nullptr) return none;
  std::string word(text);
  std::erase(word, ' ');
  if (word.empty()) return none;
  double value = none;
  const char* const begin = word.data() + (word[0] == '+' ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range) return none;
  if (error != std::errc{} || end != word.data() + word.size()) {
    fail(path, "missing values are declared as \"" + word + "\", a number expected");
  }
  return value;
}

/// Copies a block of samples into the image, as far as it lies inside.
struct Pixels {
  Image<float>& values;
  Widen to_double;
  std::size_t bytes_per_sample;
  double missing;
  std::vector<double> row;

  void put(const std::uint8_t* bytes, std::uint32_t x, std::uint32_t y, std::uint32_t width, std::uint32_t height) {
    row.resize(width);
    const auto columns = std::min(width, static_cast<std::uint32_t>(values.width) - x);
    const auto rows = std::min(height, static_cast<std::uint32_t>(values.height) - y);
    const auto missing_as_float = static_cast<float>(missing);
    for (std::uint32_t j = 0; j < rows; ++j) {
      to_double(bytes + std::size_t{j} * width * bytes_per_sample, columns, row.data());
      float* const out = values.pixels.data() + (std::size_t{y} + j) * static_cast<std::size_t>(values.width) + x;
      for (std::uint32_t i = 0; i < columns; ++i) {
        const auto value = static_cast<float>(row[i]);
        const bool none = row[i] == missing || value == missing_as_float;
        out[i] = none ? std::numeric_limits<float>::quiet_NaN() : value;
      }
    }
  }
};

void read_tiles(const Tiff& tiff, Pixels& pixels) {
  const auto width = tiff.tag<std::uint32_t>(TIFFTAG_TILEWIDTH, 0);
  const auto height = tiff.tag<std::uint32_t>(TIFFTAG_TILELENGTH, 0);
  const tmsize_t size = TIFFTileSize(tiff.get());
  if (width == 0 || height == 0 || size <= 0 || size > tmsize_t{most_bytes}) tiff.failed("malformed tiles");
  if (static_cast<std::uint64_t>(size) < std::uint64_t{width} * height * pixels.bytes_per_sample) {
    tiff.failed("malformed tiles");
  }
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(pixels.values.height); y += height) {
    for (std::uint32_t x = 0; x < static_cast<std::uint32_t>(pixels.values.width); x += width) {
      const std::uint32_t tile = TIFFComputeTile(tiff.get(), x, y, 0, 0);
      if (TIFFReadEncodedTile(tiff.get(), tile, bytes.data(), size) != size) tiff.failed("damaged TIFF");
      pixels.put(bytes.data(), x, y, width, height);
    }
  }
}

void read_rows(const Tiff& tiff, Pixels& pixels) {
  const tmsize_t size = TIFFScanlineSize(tiff.get());
  const auto width = static_cast<std::uint32_t>(pixels.values.width);
  if (size < static_cast<tmsize_t>(width * pixels.bytes_per_sample)) tiff.failed("malformed rows");
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size));
  for (std::uint32_t y = 0; y < static_cast<std::uint32_t>(pixels.values.height); ++y) {
    if (TIFFReadScanline(tiff.get(), bytes.data(), y) != 1) tiff.failed("damaged TIFF");
    pixels.put(bytes.data(), 0, y, width, 1);
  }
}

std::optional<RasterPlace> read_place(const fs::path& path, const Tiff& tiff) {
  const std::vector<double> scale = tiff.numbers(TIFFTAG_GEOPIXELSCALE);
  const std::vector<double> tie = tiff.numbers(TIFFTAG_GEOTIEPOINTS);
  const std::vector<double> matrix = tiff.numbers(TIFFTAG_GEOTRANSMATRIX);
  const Geo geo(GTIFNew(tiff.get()));
  unsigned short model = 0;
  unsigned short raster = RasterPixelIsArea;
  if (geo) {
    GTIFKeyGetSHORT(geo.get(), GTModelTypeGeoKey, &model, 0, 1);
    GTIFKeyGetSHORT(geo.get(), GTRasterTypeGeoKey, &raster, 0, 1);
  }
  RasterPlace place;
  if (scale.size() >= 2 && tie.size() >= 6) {
    place = {tie[3] - tie[0] * scale[0], tie[4] + tie[1] * scale[1], scale[0], scale[1]};
  } else if (matrix.size() >= 16) {
    if (matrix[1] != 0 || matrix[4] != 0) fail(path, "a rotated raster; rows along x and columns along y expected");
    place = {matrix[3], matrix[7], matrix[0], -matrix[5]};
  } else {
    return std::nullopt;
  }
  if (model == ModelTypeGeographic) fail(path, "coordinates in degrees; a projected raster in metres expected");
  if (!(place.spacing_x > 0 && place.spacing_y > 0) || !std::isfinite(place.spacing_x + place.spacing_y) ||
      !std::isfinite(place.x + place.y)) {
    fail(path, "pixels of no size; positive spacings expected, rows from the north down");
  }
  if (raster != RasterPixelIsPoint) {
    place.x += 0.5 * place.spacing_x;
    place.y -= 0.5 * place.spacing_y;
  }
  return place;
}

/// Everything but the pixels.
void write_header(const Tiff& tiff, int width, int height, const RasterPlace& place, const char* missing) {
  TIFF* const t = tiff.get();
  TIFFSetField(t, TIFFTAG_IMAGEWIDTH, static_cast<std::uint32_t>(width));
  TIFFSetField(t, TIFFTAG_IMAGELENGTH, static_cast<std::uint32_t>(height));
  TIFFSetField(t, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(t, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(t, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(t, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(t, TIFFTAG_ROWSPERSTRIP, TIFFDefaultStripSize(t, 0));
  const double scale[3] = {place.spacing_x, place.spacing_y, 0};
  const double corner[6] = {0, 0, 0, place.x - 0.5 * place.spacing_x, place.y + 0.5 * place.spacing_y, 0};
  TIFFSetField(t, TIFFTAG_GEOPIXELSCALE, 3, scale);
  TIFFSetField(t, TIFFTAG_GEOTIEPOINTS, 6, corner);
  if (missing != nullptr) TIFFSetField(t, gdal_nodata, missing);
  const Geo geo(GTIFNew(t));
  if (!geo) tiff.failed("cannot be written");
  GTIFKeySet(geo.get(), GTModelTypeGeoKey, TYPE_SHORT, 1, KvUserDefined);
  GTIFKeySet(geo.get(), GTRasterTypeGeoKey, TYPE_SHORT, 1, RasterPixelIsArea);
  GTIFKeySet(geo.get(), GTCitationGeoKey, TYPE_ASCII, 0, "Local engineering coordinates, x and y level, z up");
  GTIFKeySet(geo.get(), ProjLinearUnitsGeoKey, TYPE_SHORT, 1, Linear_Meter);
  if (GTIFWriteKeys(geo.get()) != 1) tiff.failed("cannot be written");
}

template <typename T>
void write(const fs::path& path, ImageView<const T> values, const RasterPlace& place, std::uint16_t format,
           const char* missing) {
  if (values.empty()) fail(path, "a raster without pixels");
  if (!(place.spacing_x > 0 && place.spacing_y > 0)) fail(path, "positive spacings expected");
  Tiff tiff(path, "w");
  TIFFSetField(tiff.get(), TIFFTAG_BITSPERSAMPLE, static_cast<int>(8 * sizeof(T)));
  TIFFSetField(tiff.get(), TIFFTAG_SAMPLEFORMAT, format);
  write_header(tiff, values.width, values.height, place, missing);
  std::vector<T> row(static_cast<std::size_t>(values.width));
  for (std::int32_t y = 0; y < values.height; ++y) {
    std::copy(values.row(y), values.row(y) + values.width, row.begin());  // libtiff may change what it is given
    if (TIFFWriteScanline(tiff.get(), row.data(), static_cast<std::uint32_t>(y)) != 1) {
      tiff.failed("cannot be written");
    }
  }
  if (TIFFFlush(tiff.get()) != 1) tiff.failed("cannot be written");
  tiff.close();
  if (!tiff.message().empty()) tiff.failed("cannot be written");
}

}  // namespace

bool is_tiff(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read");
  char magic[4] = {};
  in.read(magic, sizeof(magic));
  const auto equals = [&](const char* other) { return std::memcmp(magic, other, sizeof(magic)) == 0; };
  return in.gcount() == 4 && (equals("II*\0") || equals("MM\0*") || equals("II+\0") || equals("MM\0+"));
}

GeoRaster read_geotiff(const fs::path& path) {
  if (fs::is_directory(path) || !is_tiff(path)) fail(path, "not a TIFF");
  const Tiff tiff(path, "r");
  if (!tiff.message().empty()) tiff.failed("damaged TIFF");
  const auto width = tiff.tag<std::uint32_t>(TIFFTAG_IMAGEWIDTH, 0);
  const auto height = tiff.tag<std::uint32_t>(TIFFTAG_IMAGELENGTH, 0);
  if (width == 0 || height == 0 || width > largest_side || height > largest_side ||
      std::uint64_t{width} * height > most_pixels) {
    fail(path, "TIFF of " + std::to_string(width) + "x" + std::to_string(height) + " pixels, 1 to " +
                   std::to_string(largest_side) + " a side expected");
  }
  const auto bands = tiff.tag<std::uint16_t>(TIFFTAG_SAMPLESPERPIXEL, 1);
  const auto photometric = tiff.tag<std::uint16_t>(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  if (bands != 1) fail(path, "TIFF with " + std::to_string(bands) + " bands, one expected");
  if (photometric != PHOTOMETRIC_MINISBLACK)
    fail(path, "TIFF in colour or inverted; one band of plain values expected");
  const auto format = tiff.tag<std::uint16_t>(TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_UINT);
  const auto bits = tiff.tag<std::uint16_t>(TIFFTAG_BITSPERSAMPLE, 1);
  const Widen to_double = widener(format, bits);
  if (to_double == nullptr) {
    fail(path, "TIFF with samples of " + std::to_string(bits) +
                   " bits in a format that is not read; 8, 16 or 32-bit integers or 32 or 64-bit floats expected");
  }
  GeoRaster result;
  result.place = read_place(path, tiff);
  const double missing = missing_value(path, tiff);
  result.values = Image<float>(static_cast<int>(width), static_cast<int>(height));
  Pixels pixels{result.values, to_double, std::size_t{bits} / 8, missing, {}};
  if (TIFFIsTiled(tiff.get()) != 0) {
    read_tiles(tiff, pixels);
  } else {
    read_rows(tiff, pixels);
  }
  return result;
}

void write_geotiff(const fs::path& path, ImageView<const float> values, const RasterPlace& place) {
  write(path, values, place, SAMPLEFORMAT_IEEEFP, "nan");
}

void write_geotiff(const fs::path& path, ImageView<const std::uint8_t> values, const RasterPlace& place,
                   std::optional<std::uint8_t> missing) {
  const std::string text = missing ? std::to_string(*missing) : "";
  write(path, values, place, SAMPLEFORMAT_UINT, missing ? text.c_str() : nullptr);
}

}  // namespace ilp::host
