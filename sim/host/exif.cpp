#include "sim/host/exif.hpp"

#include <exiv2/exiv2.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <mutex>
#include <string>
#include <vector>

#include "fsw/base/date_text.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::host {
namespace fs = std::filesystem;
namespace {

using Numbers = std::vector<std::optional<double>>;

std::optional<double> fraction(double over, double under) {
  return under != 0 ? std::optional(over / under) : std::nullopt;
}

/// The numbers of a tag, each as exact as the file has it; none for a tag that is missing or no number.
Numbers numbers_of(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  if (found == exif.end()) return {};
  const Exiv2::Value& value = found->value();
  Numbers numbers;
  if (const auto* const fractions = dynamic_cast<const Exiv2::URationalValue*>(&value)) {
    for (const auto& [over, under] : fractions->value_) numbers.push_back(fraction(over, under));
  } else if (const auto* const with_sign = dynamic_cast<const Exiv2::RationalValue*>(&value)) {
    for (const auto& [over, under] : with_sign->value_) numbers.push_back(fraction(over, under));
  } else if (value.typeId() != Exiv2::asciiString && value.typeId() != Exiv2::undefined) {
    for (long i = 0; i < static_cast<long>(value.count()); ++i) numbers.emplace_back(value.toFloat(i));
  }
  return numbers;
}

std::optional<double> number_of(const Exiv2::ExifData& exif, const char* key) {
  const Numbers numbers = numbers_of(exif, key);
  return numbers.empty() || !numbers[0] || !std::isfinite(*numbers[0]) ? std::nullopt : numbers[0];
}

/// Without blanks and zero octets at its end; empty for a tag that is missing.
std::string text_of(const Exiv2::ExifData& exif, const char* key) {
  const auto found = exif.findKey(Exiv2::ExifKey(key));
  if (found == exif.end()) return {};
  std::string text = found->toString();
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// ---- lens ----

std::optional<double> focal_length(const Exiv2::ExifData& exif, const char* key, double least_mm) {
  const auto focal_mm = number_of(exif, key);
  return focal_mm && *focal_mm >= least_mm && *focal_mm <= 2000 ? focal_mm : std::nullopt;
}

/// Width of the part of the sensor that the whole image shows, from its pixels per unit of length.
std::optional<double> sensor_width_mm(const Exiv2::ExifData& exif, double width_px) {
  const auto per_unit = number_of(exif, "Exif.Photo.FocalPlaneXResolution");
  if (!per_unit || !(*per_unit > 0)) return std::nullopt;
  const double unit = number_of(exif, "Exif.Photo.FocalPlaneResolutionUnit").value_or(2);
  const double unit_mm = unit == 2 ? 25.4 : unit == 3 ? 10 : unit == 4 ? 1 : unit == 5 ? 0.001 : 0;
  const double width_mm = width_px / *per_unit * unit_mm;
  constexpr double least_mm = 1, most_mm = 100;
  return width_mm >= least_mm && width_mm <= most_mm ? std::optional(width_mm) : std::nullopt;
}

void read_lens(const Exiv2::ExifData& exif, PhotographFacts& facts) {
  facts.focal_mm = focal_length(exif, "Exif.Photo.FocalLength", 0.5);
  facts.focal_film_mm = focal_length(exif, "Exif.Photo.FocalLengthIn35mmFilm", 4);
  const double longer = std::max(facts.width, facts.height), shorter = std::min(facts.width, facts.height);
  // Of the image as the camera made it; a program may have reduced, cut or turned it.
  const double x = number_of(exif, "Exif.Photo.PixelXDimension").value_or(0);
  const double y = number_of(exif, "Exif.Photo.PixelYDimension").value_or(0);
  double whole = longer;
  if (x > 0 && y > 0) {
    whole = std::max(x, y);
    // A pixel of the shorter side may have been lost when the image was reduced.
    const double slack = 0.01 + 1 / shorter;
    if (std::fabs(whole / std::min(x, y) * shorter / longer - 1) > slack) {
      if (facts.focal_mm || facts.focal_film_mm) {
        facts.lens_fault = "EXIF speaks of " + size_text(static_cast<int>(x), static_cast<int>(y)) +
                           " pixels, the image has another shape: it was cut";
      }
      return;
    }
  }
  constexpr double film_width_mm = 36;
  const double share = 0.5 * facts.width / longer;
  if (facts.focal_film_mm) {
    // The longer side of the image is that of the film.
    facts.field_of_view_rad = 2 * std::atan(share * film_width_mm / *facts.focal_film_mm);
  } else if (const auto sensor_mm = sensor_width_mm(exif, whole); sensor_mm && facts.focal_mm) {
    facts.field_of_view_rad = 2 * std::atan(share * *sensor_mm / *facts.focal_mm);
  }
}

/// Cameras with several sensors write the same model into the images of all, and the band beside it.
std::string camera_of(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp) {
  std::string name = text_of(exif, "Exif.Image.Model");
  for (const auto& property : xmp) {
    if (property.tagName() == "BandName") name += (name.empty() ? "band " : ", band ") + property.toString();
  }
  return name;
}

// ---- time ----

/// Of a date as scanned; none where the calendar has none.
std::optional<std::int64_t> time_ns_of(const std::tm& tm) {
  TimeNs since_1970 = 0;
  const bool valid = time_of_date(tm.tm_year, tm.tm_mon, tm.tm_mday, tm.tm_hour, tm.tm_min, tm.tm_sec, since_1970);
  return valid ? std::optional(since_1970) : std::nullopt;
}

std::optional<std::int64_t> exposure_time(const Exiv2::ExifData& exif) {
  std::tm tm{};
  if (std::sscanf(text_of(exif, "Exif.Photo.DateTimeOriginal").c_str(), "%4d%*1[:-]%2d%*1[:-]%2d%*1[ T]%2d:%2d:%2d",
                  &tm.tm_year, &tm.tm_mon, &tm.tm_mday, &tm.tm_hour, &tm.tm_min, &tm.tm_sec) != 6)
    return std::nullopt;
  const auto whole = time_ns_of(tm);
  if (!whole) return std::nullopt;
  std::int64_t time_ns = *whole;
  // Digits of a fraction of the second.
  std::int64_t unit = 100'000'000;
  for (const char c : text_of(exif, "Exif.Photo.SubSecTimeOriginal")) {
    if (c < '0' || c > '9' || unit == 0) break;
    time_ns += (c - '0') * unit;
    unit /= 10;
  }
  return time_ns;
}

std::optional<std::int64_t> zone_of(const Exiv2::ExifData& exif) {
  int hours = 0, minutes = 0;
  char sign = 0;
  if (std::sscanf(text_of(exif, "Exif.Photo.OffsetTimeOriginal").c_str(), "%c%2d:%2d", &sign, &hours, &minutes) != 3 ||
      (sign != '+' && sign != '-') || hours < 0 || hours > 14 || minutes < 0 || minutes > 59) {
    return std::nullopt;
  }
  return (sign == '-' ? -1 : 1) * (hours * 3600 + minutes * 60);
}

// ---- place ----

/// Degrees, minutes and seconds, or hours, minutes and seconds. What stands last may be unknown where the value before
/// it has a fraction, as in decimal degrees. 60 of a smaller unit are one of the larger: writers round and do not
/// carry.
std::optional<double> sexagesimal(Numbers numbers) {
  if (numbers.empty() || numbers.size() > 3 || !numbers[0]) return std::nullopt;
  numbers.resize(3);
  double value = 0, unit = 1;
  bool ended = false;
  for (std::size_t i = 0; i < numbers.size(); ++i, unit /= 60) {
    if (!numbers[i]) {
      if (!ended && *numbers[i - 1] == std::floor(*numbers[i - 1])) return std::nullopt;
      ended = true;
      continue;
    }
    const bool valid = !ended && *numbers[i] >= 0 && *numbers[i] <= (i == 0 ? 360 : 60);
    if (!valid) return std::nullopt;
    value += *numbers[i] * unit;
  }
  return value;
}

/// 1 or -1 by the letter of the reference.
std::optional<double> side(const std::string& letter, char positive, char negative) {
  if (letter.empty()) return std::nullopt;
  const char c = static_cast<char>(letter[0] & ~0x20);
  return c == positive ? std::optional(1.0) : c == negative ? std::optional(-1.0) : std::nullopt;
}

/// Above the level that the reference names; 1 and 3 (Exif 3.0) lie below it.
std::optional<double> elevation_of(const Exiv2::ExifData& exif) {
  const auto altitude = number_of(exif, "Exif.GPSInfo.GPSAltitude");
  if (!altitude) return std::nullopt;
  const std::string reference = text_of(exif, "Exif.GPSInfo.GPSAltitudeRef");
  const bool below = reference == "1" || reference == "3";
  constexpr double lowest_m = -500, highest_m = 100'000;
  const double elevation = below ? -std::fabs(*altitude) : *altitude;
  return elevation >= lowest_m && elevation <= highest_m ? std::optional(elevation) : std::nullopt;
}

void read_place(const Exiv2::ExifData& exif, PhotographFacts& facts) {
  const Numbers north_by = numbers_of(exif, "Exif.GPSInfo.GPSLatitude"),
                east_by = numbers_of(exif, "Exif.GPSInfo.GPSLongitude");
  if (north_by.empty() && east_by.empty()) return;
  const auto latitude = sexagesimal(north_by), longitude = sexagesimal(east_by);
  const auto north = side(text_of(exif, "Exif.GPSInfo.GPSLatitudeRef"), 'N', 'S');
  const auto east = side(text_of(exif, "Exif.GPSInfo.GPSLongitudeRef"), 'E', 'W');
  const auto unknown = [](const Numbers& numbers) { return !numbers.empty() && !numbers[0]; };
  if (unknown(north_by) || unknown(east_by)) {
    facts.place_fault = "an unknown latitude or longitude (a fraction over 0)";
  } else if (!latitude || !longitude) {
    facts.place_fault = "latitude and longitude are not both degrees, minutes and seconds";
  } else if (!north || !east) {
    facts.place_fault = "latitude without N or S, or longitude without E or W";
  } else if (*latitude > 90 || *longitude > 180) {
    facts.place_fault = "a latitude beyond 90 or a longitude beyond 180 degrees";
  } else if (*latitude == 0 && *longitude == 0) {
    facts.place_fault = "latitude and longitude of exactly 0, which receivers without a position write";
  } else if (text_of(exif, "Exif.GPSInfo.GPSStatus") == "V") {
    facts.place_fault = "the receiver had no position (status V)";
  }
  if (!facts.place_fault.empty()) return;
  GeoTag tag{*east * *longitude, *north * *latitude, elevation_of(exif), {}};
  const auto error = number_of(exif, "Exif.GPSInfo.GPSHPositioningError");
  if (error && *error > 0 && *error < 10'000) tag.horizontal_error_m = error;
  facts.place = tag;
}

std::optional<std::int64_t> gps_time(const Exiv2::ExifData& exif) {
  const auto hours = sexagesimal(numbers_of(exif, "Exif.GPSInfo.GPSTimeStamp"));
  std::tm tm{};
  if (!hours || *hours > 24 ||
      std::sscanf(text_of(exif, "Exif.GPSInfo.GPSDateStamp").c_str(), "%4d%*1[:-]%2d%*1[:-]%2d", &tm.tm_year,
                  &tm.tm_mon, &tm.tm_mday) != 3 ||
      tm.tm_year < 1980) {
    return std::nullopt;
  }
  const auto day = time_ns_of(tm);
  if (!day) return std::nullopt;
  return *day + std::llround(*hours * 3600e6) * 1000;
}

// ---- attitude ----

std::optional<double> xmp_number(const Exiv2::XmpData& xmp, const std::string& name) {
  for (const auto& property : xmp) {
    if (property.tagName() != name) continue;
    const std::string text = property.toString();
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end != text.c_str() && *end == '\0' && std::fabs(value) <= 360) return value;
  }
  return std::nullopt;
}

void read_attitude(const Exiv2::ExifData& exif, const Exiv2::XmpData& xmp, PhotographFacts& facts) {
  const auto yaw = xmp_number(xmp, "GimbalYawDegree"), pitch = xmp_number(xmp, "GimbalPitchDegree");
  const double roll = xmp_number(xmp, "GimbalRollDegree").value_or(0);
  // All of them 0 is what is written by who has none.
  if (yaw && pitch && (*yaw != 0 || *pitch != 0 || roll != 0)) facts.gimbal = GimbalAngles{*yaw, *pitch, roll};
  const auto direction = number_of(exif, "Exif.GPSInfo.GPSImgDirection");
  if (direction && *direction >= 0 && *direction <= 360) facts.direction_deg = direction;
}

void set_up_exiv2() {
  Exiv2::LogMsg::setLevel(Exiv2::LogMsg::mute);
  Exiv2::XmpParser::initialize();
}

}  // namespace

void read_exif(const fs::path& path, PhotographFacts& facts) {
  static std::once_flag once;
  std::call_once(once, set_up_exiv2);
  try {
    const auto image = Exiv2::ImageFactory::open(path.string());
    image->readMetadata();
    const Exiv2::ExifData& exif = image->exifData();
    facts.camera = camera_of(exif, image->xmpData());
    read_lens(exif, facts);
    facts.time_ns = exposure_time(exif);
    facts.zone_s = zone_of(exif);
    facts.gps_time_ns = gps_time(exif);
    read_attitude(exif, image->xmpData(), facts);
    read_place(exif, facts);
  } catch (const std::exception&) {
    // A file without metadata that exiv2 reads: PGM, or damaged tags.
  }
}

}  // namespace ilp::host
