#include "sim/host/photograph.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

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

std::optional<double> focal_length(GDALDataset& dataset, const char* name, double least_mm) {
  const auto focal_mm = exif_number(dataset, name);
  return focal_mm && *focal_mm >= least_mm && *focal_mm <= 2000 ? focal_mm : std::nullopt;
}

double field_of_view(const PhotographFacts& facts, double focal_film_mm) {
  constexpr double film_width_mm = 36;
  // The longer side of the image is that of the film.
  return 2 * std::atan(0.5 * film_width_mm * facts.width / std::max(facts.width, facts.height) / focal_film_mm);
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

/// Degrees, minutes and seconds, or hours, minutes and seconds; none where they are no such numbers.
std::optional<double> sexagesimal(const std::optional<std::string>& text) {
  double whole = 0, minutes = 0, seconds = 0;
  if (!text || std::sscanf(text->c_str(), " ( %lf ) ( %lf ) ( %lf )", &whole, &minutes, &seconds) != 3) {
    return std::nullopt;
  }
  const bool sound = whole >= 0 && whole <= 180 && minutes >= 0 && minutes < 60 && seconds >= 0 && seconds < 60;
  return sound ? std::optional(whole + minutes / 60 + seconds / 3600) : std::nullopt;
}

/// 1 or -1 by the letter of the reference.
std::optional<double> side(const std::optional<std::string>& letter, char positive, char negative) {
  if (!letter || letter->empty() || ((*letter)[0] != positive && (*letter)[0] != negative)) return std::nullopt;
  return (*letter)[0] == positive ? 1.0 : -1.0;
}

void read_place(GDALDataset& dataset, PhotographFacts& facts) {
  const auto latitude_text = exif(dataset, "EXIF_GPSLatitude"), longitude_text = exif(dataset, "EXIF_GPSLongitude");
  if (!latitude_text && !longitude_text) return;
  const auto latitude = sexagesimal(latitude_text), longitude = sexagesimal(longitude_text);
  const auto north = side(exif(dataset, "EXIF_GPSLatitudeRef"), 'N', 'S');
  const auto east = side(exif(dataset, "EXIF_GPSLongitudeRef"), 'E', 'W');
  if (!latitude || !longitude) {
    facts.place_fault = "latitude and longitude are not both degrees, minutes and seconds";
  } else if (!north || !east) {
    facts.place_fault = "latitude without N or S, or longitude without E or W";
  } else if (*latitude > 90 || *longitude > 180) {
    facts.place_fault = "a latitude beyond 90 or a longitude beyond 180 degrees";
  } else if (*latitude == 0 || *longitude == 0) {
    // GDAL reads a division by nothing as 0 too.
    facts.place_fault = "a latitude or longitude of exactly 0, which receivers without a position write";
  }
  if (!facts.place_fault.empty()) return;
  GeoTag tag{*east * *longitude, *north * *latitude, {}, {}};
  constexpr double lowest_m = -500, highest_m = 100'000;
  if (const auto altitude = exif_number(dataset, "EXIF_GPSAltitude")) {
    const std::string reference = exif(dataset, "EXIF_GPSAltitudeRef").value_or("0");
    const double elevation = reference.find('1') != std::string::npos ? -*altitude : *altitude;
    if (elevation >= lowest_m && elevation <= highest_m) tag.elevation_m = elevation;
  }
  const auto error = exif_number(dataset, "EXIF_GPSHPositioningError");
  if (error && *error > 0 && *error < 10'000) tag.horizontal_error_m = error;
  facts.place = tag;
}

std::optional<std::int64_t> gps_time(GDALDataset& dataset) {
  const auto date = exif(dataset, "EXIF_GPSDateStamp");
  const auto hours = sexagesimal(exif(dataset, "EXIF_GPSTimeStamp"));
  std::tm tm{};
  if (!date || !hours || *hours >= 24 ||
      std::sscanf(date->c_str(), "%4d:%2d:%2d", &tm.tm_year, &tm.tm_mon, &tm.tm_mday) != 3 || tm.tm_year < 1980 ||
      tm.tm_mon < 1 || tm.tm_mon > 12 || tm.tm_mday < 1 || tm.tm_mday > 31) {
    return std::nullopt;
  }
  tm.tm_year -= 1900;
  tm.tm_mon -= 1;
  return std::int64_t{timegm(&tm)} * 1'000'000'000 + std::llround(*hours * 3600e6) * 1000;
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
  facts.focal_mm = focal_length(*dataset, "EXIF_FocalLength", 0.5);
  facts.focal_film_mm = focal_length(*dataset, "EXIF_FocalLengthIn35mmFilm", 4);
  if (facts.focal_film_mm) facts.field_of_view_rad = field_of_view(facts, *facts.focal_film_mm);
  facts.time_ns = exposure_time(*dataset);
  facts.gps_time_ns = gps_time(*dataset);
  read_place(*dataset, facts);
  return facts;
}

}  // namespace ilp::host
