#include "tests/support/exif_file.hpp"

#include <cpl_string.h>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "sim/host/gdal_session.hpp"

namespace ilp::test {
namespace {

void put(std::string& text, std::uint32_t value, int octets) {
  for (int i = 0; i < octets; ++i) text += static_cast<char>(value >> (8 * i) & 255U);
}

enum Type : std::uint16_t { octet = 1, ascii = 2, short_number = 3, long_number = 4, rational = 5 };

struct Entry {
  std::uint16_t tag;
  Type type;
  std::uint32_t count;
  std::string bytes;
};

Entry text_entry(std::uint16_t tag, const std::string& text) {
  const std::string bytes = text + std::string(1, '\0');
  return {tag, ascii, static_cast<std::uint32_t>(bytes.size()), bytes};
}

Entry rational_entry(std::uint16_t tag, const std::vector<ExifRational>& values) {
  Entry entry{tag, rational, static_cast<std::uint32_t>(values.size()), {}};
  for (const ExifRational& value : values) {
    put(entry.bytes, value.over, 4);
    put(entry.bytes, value.under, 4);
  }
  return entry;
}

Entry number_entry(std::uint16_t tag, Type type, std::uint32_t value) {
  Entry entry{tag, type, 1, {}};
  put(entry.bytes, value, type == long_number ? 4 : type == short_number ? 2 : 1);
  return entry;
}

/// A directory that begins at `offset` of the TIFF file, with the values that do not fit into its entries behind it.
std::string directory(const std::vector<Entry>& entries, std::uint32_t offset) {
  std::string head, values;
  put(head, static_cast<std::uint32_t>(entries.size()), 2);
  const std::uint32_t values_at = offset + 2 + 12 * static_cast<std::uint32_t>(entries.size()) + 4;
  for (const Entry& entry : entries) {
    put(head, entry.tag, 2);
    put(head, entry.type, 2);
    put(head, entry.count, 4);
    if (entry.bytes.size() <= 4) {
      head += entry.bytes + std::string(4 - entry.bytes.size(), '\0');
    } else {
      put(head, values_at + static_cast<std::uint32_t>(values.size()), 4);
      values += entry.bytes;
      if (values.size() % 2 != 0) values += '\0';
    }
  }
  put(head, 0, 4);
  return head + values;
}

std::vector<Entry> exif_entries(const ExifTags& tags) {
  std::vector<Entry> entries;
  if (!tags.time.empty()) entries.push_back(text_entry(0x9003, tags.time));
  if (!tags.zone.empty()) entries.push_back(text_entry(0x9011, tags.zone));
  if (!tags.subsecond.empty()) entries.push_back(text_entry(0x9291, tags.subsecond));
  if (tags.focal_mm) entries.push_back(rational_entry(0x920A, {*tags.focal_mm}));
  if (tags.width) entries.push_back(number_entry(0xA002, long_number, *tags.width));
  if (tags.height) entries.push_back(number_entry(0xA003, long_number, *tags.height));
  if (tags.pixels_per_inch) {
    entries.push_back(rational_entry(0xA20E, {*tags.pixels_per_inch}));
    entries.push_back(number_entry(0xA210, short_number, 2));
  }
  if (tags.focal_35mm) entries.push_back(number_entry(0xA405, short_number, *tags.focal_35mm));
  return entries;
}

std::vector<Entry> gps_entries(const ExifTags& tags) {
  std::vector<Entry> entries;
  if (!tags.latitude_letter.empty()) entries.push_back(text_entry(1, tags.latitude_letter));
  if (!tags.latitude.empty()) entries.push_back(rational_entry(2, tags.latitude));
  if (!tags.longitude_letter.empty()) entries.push_back(text_entry(3, tags.longitude_letter));
  if (!tags.longitude.empty()) entries.push_back(rational_entry(4, tags.longitude));
  if (tags.below_sea) entries.push_back(number_entry(5, octet, *tags.below_sea));
  if (tags.altitude_m) entries.push_back(rational_entry(6, {*tags.altitude_m}));
  if (!tags.gps_time.empty()) entries.push_back(rational_entry(7, tags.gps_time));
  if (tags.direction_deg) entries.push_back(rational_entry(0x11, {*tags.direction_deg}));
  if (!tags.gps_date.empty()) entries.push_back(text_entry(0x1D, tags.gps_date));
  if (tags.error_m) entries.push_back(rational_entry(0x1F, {*tags.error_m}));
  return entries;
}

std::string segment(const std::string& content) {
  const std::size_t size = content.size() + 2;
  if (size > 0xFFFF) throw std::length_error("an Exif segment of more than 64 KiB");
  return std::string("\xFF\xE1") + static_cast<char>(size >> 8U) + static_cast<char>(size & 255U) + content;
}

std::vector<ExifRational> sexagesimal(double degrees) {
  constexpr std::uint32_t unit = 100'000;
  auto rest = static_cast<std::uint64_t>(std::llround(std::fabs(degrees) * 3600 * unit));
  const auto seconds = static_cast<std::uint32_t>(rest % (60ULL * unit));
  rest /= 60ULL * unit;
  return {{static_cast<std::uint32_t>(rest / 60), 1}, {static_cast<std::uint32_t>(rest % 60), 1}, {seconds, unit}};
}

}  // namespace

void ExifTags::set_place(double longitude_deg, double latitude_deg, double elevation_m) {
  latitude = sexagesimal(latitude_deg);
  longitude = sexagesimal(longitude_deg);
  latitude_letter = latitude_deg < 0 ? "S" : "N";
  longitude_letter = longitude_deg < 0 ? "W" : "E";
  below_sea = elevation_m < 0 ? 1 : 0;
  altitude_m = ExifRational{static_cast<std::uint32_t>(std::llround(std::fabs(elevation_m) * 1000)), 1000};
}

std::string exif_segment(const ExifTags& tags) {
  const std::vector<Entry> exif = exif_entries(tags), gps = gps_entries(tags);
  constexpr std::uint32_t first = 8;
  const auto head_at = [&](std::uint32_t exif_begin, std::uint32_t gps_begin) {
    std::vector<Entry> entries;
    if (!tags.model.empty()) entries.push_back(text_entry(0x0110, tags.model));
    entries.push_back(number_entry(0x8769, long_number, exif_begin));
    entries.push_back(number_entry(0x8825, long_number, gps_begin));
    return directory(entries, first);
  };
  const std::uint32_t exif_at = first + static_cast<std::uint32_t>(head_at(0, 0).size());
  const std::string exif_part = directory(exif, exif_at);
  const std::uint32_t gps_at = exif_at + static_cast<std::uint32_t>(exif_part.size());
  std::string tiff("II*\0", 4);
  put(tiff, first, 4);
  tiff += head_at(exif_at, gps_at);
  tiff += exif_part + directory(gps, gps_at);
  std::string all = segment(std::string("Exif\0\0", 6) + tiff);
  if (!tags.gimbal.empty()) {
    all += segment(std::string("http://ns.adobe.com/xap/1.0/\0", 29) +
                   "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
                   "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description rdf:about=\"\" "
                   "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\" " +
                   tags.gimbal + "/></rdf:RDF></x:xmpmeta>");
  }
  return all;
}

void write_photograph(const std::filesystem::path& path, const host::Raster<host::Rgb>& picture, const ExifTags& tags) {
  const std::filesystem::path plain = path.string() + ".plain";
  {
    const host::GdalSession session;
    const host::Dataset memory(GetGDALDriverManager()->GetDriverByName("MEM")->Create("", picture.width, picture.height,
                                                                                      3, GDT_Byte, nullptr));
    std::vector<std::uint8_t> samples(picture.samples.size());
    for (int band = 1; band <= 3; ++band) {
      std::transform(picture.samples.begin(), picture.samples.end(), samples.begin(), [band](const host::Rgb& c) {
        return band == 1 ? c.r : band == 2 ? c.g : c.b;
      });
      if (memory->GetRasterBand(band)->RasterIO(GF_Write, 0, 0, picture.width, picture.height, samples.data(),
                                                picture.width, picture.height, GDT_Byte, 0, 0, nullptr) != CE_None) {
        throw host::gdal_error("a photograph");
      }
    }
    CPLStringList options;
    options.SetNameValue("QUALITY", "98");
    const host::Dataset written(GetGDALDriverManager()->GetDriverByName("JPEG")->CreateCopy(
        plain.c_str(), memory.get(), FALSE, options.List(), nullptr, nullptr));
    if (!written) throw host::gdal_error(path.string());
  }
  std::ifstream in(plain, std::ios::binary);
  std::string jpeg{std::istreambuf_iterator<char>(in), {}};
  jpeg.insert(2, exif_segment(tags));
  std::ofstream out(path, std::ios::binary);
  if (!(out << jpeg).flush()) throw std::runtime_error(path.string() + ": cannot be written");
  std::filesystem::remove(plain);
}

}  // namespace ilp::test
