// Writes JPEG files as cameras do: in colour, with an Exif segment of time, focal length and position (CIPA DC-008).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/host/raster.hpp"

namespace ilp::test {

/// The fraction `over` / `under`.
struct ExifRational {
  std::uint32_t over = 0, under = 1;
};

/// Values of the tags. Empty ones are not written. Values are written unchecked.
struct ExifTags {
  std::string model;      ///< model of the camera
  std::string time;       ///< "2026:11:22 08:40:00"
  std::string subsecond;  ///< decimal digits of the fraction of a second
  std::optional<std::uint16_t> focal_35mm;
  std::string latitude_letter, longitude_letter;
  std::vector<ExifRational> latitude, longitude;  ///< degrees, minutes, seconds
  std::optional<std::uint8_t> below_sea;
  std::optional<ExifRational> altitude_m, error_m;
  std::vector<ExifRational> gps_time;  ///< hours, minutes, seconds
  std::string gps_date;                ///< "2026:11:22"
  std::string zone;                    ///< "+02:00"
  std::optional<ExifRational> focal_mm, direction_deg;
  std::optional<std::uint32_t> width, height;   ///< picture size that the tags state, px
  std::optional<ExifRational> pixels_per_inch;  ///< resolution of the focal plane
  std::string gimbal;                           ///< text of the drone-dji attributes in XMP

  /// Sets the position, rounded to 1e-5 arc seconds (a third of a millimetre).
  void set_place(double longitude_deg, double latitude_deg, double elevation_m);
};

/// Returns the segment with its marker. Throws std::length_error if it exceeds 64 KiB.
[[nodiscard]] std::string exif_segment(const ExifTags& tags);
/// Writes a JPEG file with the tags. Throws std::runtime_error if it cannot be written.
void write_photograph(const std::filesystem::path& path, const host::Raster<host::Rgb>& picture, const ExifTags& tags);

}  // namespace ilp::test
