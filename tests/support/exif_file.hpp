// JPEG files as cameras write them: colours, and an Exif segment with time, focal length and position (CIPA DC-008).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/host/raster.hpp"

namespace ilp::test {

struct ExifRational {
  std::uint32_t over = 0, under = 1;
};

/// What is not given is not written. Values are written as they are, right or wrong.
struct ExifTags {
  std::string model;      ///< of the camera
  std::string time;       ///< "2026:11:22 08:40:00"
  std::string subsecond;  ///< digits of the fraction
  std::optional<std::uint16_t> focal_35mm;
  std::string latitude_letter, longitude_letter;
  std::vector<ExifRational> latitude, longitude;  ///< degrees, minutes, seconds
  std::optional<std::uint8_t> below_sea;
  std::optional<ExifRational> altitude_m, error_m;
  std::vector<ExifRational> gps_time;  ///< hours, minutes, seconds
  std::string gps_date;                ///< "2026:11:22"
  std::string zone;                    ///< "+02:00"
  std::optional<ExifRational> focal_mm, direction_deg;
  std::optional<std::uint32_t> width, height;   ///< as the tags state them
  std::optional<ExifRational> pixels_per_inch;  ///< of the focal plane
  std::string gimbal;                           ///< attributes of drone-dji in XMP, as they stand in the file

  /// Degrees, minutes and seconds to 1e-5 seconds, a third of a millimetre.
  void set_place(double longitude_deg, double latitude_deg, double elevation_m);
};

/// The segment with its marker. Throws std::length_error beyond 64 KiB.
[[nodiscard]] std::string exif_segment(const ExifTags& tags);
/// Throws std::runtime_error.
void write_photograph(const std::filesystem::path& path, const host::Raster<host::Rgb>& picture, const ExifTags& tags);

}  // namespace ilp::test
