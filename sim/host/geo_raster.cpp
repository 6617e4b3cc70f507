#include "sim/host/geo_raster.hpp"

#include <cpl_string.h>
#include <gdal_frmts.h>
#include <ogr_spatialref.h>
#include <proj.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <string>

#include "sim/host/files.hpp"
#include "sim/host/gdal_session.hpp"
#include "sim/host/height_units.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

constexpr int largest_side = 32768;
constexpr std::int64_t most_pixels = std::int64_t{1} << 28U;  // a short file must not cost gigabytes
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

void register_raster_drivers() {
  GDALRegister_GTiff();
  GDALRegister_PNG();
}

/// Closes PROJ's database after the dataset: a flight in this process needs the memory of SQLite for itself.
struct SystemsCleanup {
  ~SystemsCleanup() {
    OSRCleanup();
    proj_cleanup();
  }
};

/// Messages of GDAL while a file is read. A tag that is cut off by the file's end is only a warning to libtiff;
/// warnings about unknown tags say nothing about the file.
class Messages {
 public:
  Messages() { CPLPushErrorHandlerEx(keep, &first_); }
  ~Messages() { CPLPopErrorHandler(); }
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;
  [[nodiscard]] const std::string& first() const { return first_; }

 private:
  static void keep(CPLErr kind, CPLErrorNum, const char* message) {
    auto& first = *static_cast<std::string*>(CPLGetErrorHandlerUserData());
    if (first.empty() && (kind >= CE_Failure || std::strstr(message, "tag ignored") != nullptr)) first = message;
  }
  std::string first_;
};

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw std::runtime_error(path.string() + ": " + what);
}

void check_band(const fs::path& path, GDALDataset& file) {
  const int width = file.GetRasterXSize(), height = file.GetRasterYSize(), bands = file.GetRasterCount();
  if (width > largest_side || height > largest_side || std::int64_t{width} * height > most_pixels) {
    fail(path, size_text(width, height) + " pixels, 1 to " + std::to_string(largest_side) + " a side expected");
  }
  if (bands != 1) fail(path, "a picture in colour or with " + std::to_string(bands) + " bands, one expected");
  GDALRasterBand& band = *file.GetRasterBand(1);
  if (band.GetColorTable() != nullptr || band.GetMetadataItem("MINISWHITE", "IMAGE_STRUCTURE") != nullptr) {
    fail(path, "in colour or inverted; one band of plain values expected");
  }
  if (GDALDataTypeIsComplex(band.GetRasterDataType()) != 0) fail(path, "complex numbers; real ones expected");
}

std::optional<RasterPlace> read_place(const fs::path& path, GDALDataset& file) {
  std::array<double, 6> t{};
  if (file.GetGeoTransform(t.data()) != CE_None) return std::nullopt;
  const OGRSpatialReference* const system = file.GetSpatialRef();
  if (system != nullptr && system->IsGeographic() != 0) {
    fail(path, "coordinates in degrees; a projected raster in metres expected");
  }
  if (t[2] != 0 || t[4] != 0) fail(path, "a rotated raster; rows along x and columns along y expected");
  const double metres = metres_per_axis_unit(file);
  const RasterPlace place{metres * (t[0] + 0.5 * t[1]), metres * (t[3] + 0.5 * t[5]), metres * t[1], -metres * t[5]};
  if (!(place.spacing_x > 0 && place.spacing_y > 0) || !std::isfinite(place.spacing_x + place.spacing_y) ||
      !std::isfinite(place.x + place.y)) {
    fail(path, "pixels of no size; positive spacings expected, rows from the north down");
  }
  return place;
}

}  // namespace

bool is_raster_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) fail(path, "cannot be read: " + read_failure(errno));
  std::string magic(4, '\0');
  in.read(magic.data(), 4);
  for (const char* known : {"II*\0", "MM\0*", "II+\0", "MM\0+", "\x89PNG"}) {
    if (magic.compare(0, 4, known, 4) == 0) return in.gcount() == 4;
  }
  return false;
}

GeoRaster read_raster(const fs::path& path) {
  if (fs::is_directory(path) || !is_raster_file(path)) fail(path, "not a TIFF or PNG");
  const GdalSession gdal(register_raster_drivers);
  const Messages messages;
  const SystemsCleanup cleanup{};
  const auto damaged = [&] { fail(path, "damaged: " + messages.first()); };
  constexpr const char* drivers[] = {"GTiff", "PNG", nullptr};
  const Dataset file(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers));
  if (!file || !messages.first().empty()) damaged();
  check_band(path, *file);
  GeoRaster result;
  result.values = Raster<float>(file->GetRasterXSize(), file->GetRasterYSize());
  if (std::strcmp(file->GetDriver()->GetDescription(), "PNG") != 0) result.place = read_place(path, *file);
  Raster<float>& values = result.values;
  GDALRasterBand& band = *file->GetRasterBand(1);
  if (band.RasterIO(GF_Read, 0, 0, values.width, values.height, values.samples.data(), values.width, values.height,
                    GDT_Float32, 0, 0, nullptr) != CE_None ||
      !messages.first().empty()) {
    damaged();
  }
  const HeightUnits units = height_units(path, *file);
  for (float& value : values.samples)
    value = units.is_missing(value) ? nan : static_cast<float>(units.metres * double{value} + units.offset_m);
  return result;
}

void write_geotiff(const fs::path& path, ImageView<const float> values, const RasterPlace& place) {
  if (values.empty()) fail(path, "a raster without pixels");
  if (!(place.spacing_x > 0 && place.spacing_y > 0)) fail(path, "positive spacings expected");
  const GdalSession gdal(register_raster_drivers);
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  GDALDriver* const driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  Dataset file(driver->Create(path.c_str(), values.width, values.height, 1, GDT_Float32, options.List()));
  if (!file) throw gdal_error(path.string() + ": cannot be written");
  std::array<double, 6> transform = {
      place.x - 0.5 * place.spacing_x, place.spacing_x, 0, place.y + 0.5 * place.spacing_y, 0, -place.spacing_y};
  OGRSpatialReference system;
  system.SetLocalCS("Local engineering coordinates, x and y level, z up");
  system.SetLinearUnits(SRS_UL_METER, 1);
  file->SetGeoTransform(transform.data());
  file->SetSpatialRef(&system);
  GDALRasterBand& band = *file->GetRasterBand(1);
  band.SetNoDataValue(nan);
  // GDAL takes what it writes as memory that may be changed, and changes nothing.
  auto* const pixels = const_cast<float*>(values.data);
  if (band.RasterIO(GF_Write, 0, 0, values.width, values.height, pixels, values.width, values.height, GDT_Float32, 0,
                    std::int64_t{values.stride} * static_cast<std::int64_t>(sizeof(float)), nullptr) == CE_None) {
    file.reset();  // What is left is written when it closes.
  }
  if (file || CPLGetLastErrorType() == CE_Failure) throw gdal_error(path.string() + ": cannot be written");
}

}  // namespace ilp::host
