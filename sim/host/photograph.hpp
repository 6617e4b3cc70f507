// Reads photographs as users have them: JPEG, TIFF, and PNG or PGM with up to 16 bits, with their metadata.
// Every function throws std::runtime_error, or DamagedPhotograph or TooLargePhotograph derived from it, that names the
// file and what was expected.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/host/raster.hpp"

namespace ilp::host {

/// The data after the header are damaged or truncated.
struct DamagedPhotograph : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// More pixels than the programs take (image_io.hpp), or than this machine has memory for.
struct TooLargePhotograph : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Photograph {
  Raster<std::uint16_t> grey;  ///< luma of ITU-R BT.601 where the file has colours
  bool deep = false;           ///< more than 8 bits per sample
};
/// Reads a photograph as grey. Any warning of the JPEG decoder counts as damage, although the decoder would fill
/// missing data with grey. Palette colours become luma; alpha is ignored.
[[nodiscard]] Photograph read_photograph(const std::filesystem::path& path);

/// Position on the Earth that a photograph states.
struct GeoTag {
  double longitude_deg = 0, latitude_deg = 0;
  std::optional<double> elevation_m;         ///< above sea level
  std::optional<double> horizontal_error_m;  ///< as the receiver stated it
};

/// Reads a photograph with 8 bits per colour. A grey file gives three equal values.
[[nodiscard]] Raster<Rgb> read_colours(const std::filesystem::path& path);

/// Attitude of a camera on a gimbal, as in DJI's XMP: yaw clockwise from north, pitch up from the horizon (-90:
/// straight down), roll clockwise about the optical axis.
struct GimbalAngles {
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};

/// Metadata of a photograph. A member is empty if the header does not state it, or states a fraction with the
/// denominator 0.
struct PhotographFacts {
  int width = 0, height = 0;
  bool deep = false;
  std::string camera;                   ///< model, and band of a multispectral camera; may be empty
  std::optional<double> focal_mm;       ///< focal length
  std::optional<double> focal_film_mm;  ///< equivalent focal length for 35 mm film
  /// Horizontal; from the focal length for 35 mm film, else from the focal length and the pixel density of the sensor.
  std::optional<double> field_of_view_rad;
  std::string lens_fault;                   ///< why a focal length gives no field of view; else empty
  std::optional<std::int64_t> time_ns;      ///< exposure, since 1970, by the camera's clock
  std::optional<std::int64_t> zone_s;       ///< offset of the camera's clock from UTC, positive to the east
  std::optional<std::int64_t> gps_time_ns;  ///< of the position fix, since 1970, UTC
  std::optional<GimbalAngles> gimbal;
  std::optional<double> direction_deg;  ///< azimuth of the line of sight, clockwise from north
  std::optional<GeoTag> place;
  std::string place_fault;  ///< why the position in the header is not used; else empty
};
[[nodiscard]] PhotographFacts read_photograph_facts(const std::filesystem::path& path);

}  // namespace ilp::host
