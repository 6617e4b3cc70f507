// Photographs as cameras and their programs leave them: JPEG, TIFF, and PNG or PGM with up to 16 bits.
// Every function throws std::runtime_error that names the file and what was expected; DamagedPhotograph and
// TooLargePhotograph are such.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "sim/host/raster.hpp"

namespace ilp::host {

/// What stands behind the header is damaged or cut off.
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
/// A JPEG about whose data its decoder complains is damaged, even where it would fill the rest with grey. Colour tables
/// become luma; alpha is left out.
[[nodiscard]] Photograph read_photograph(const std::filesystem::path& path);

/// Where a photograph says that it was taken, on the Earth.
struct GeoTag {
  double longitude_deg = 0, latitude_deg = 0;
  std::optional<double> elevation_m;         ///< above sea level
  std::optional<double> horizontal_error_m;  ///< that the receiver stated
};

/// The colours, 8 bits each; three times the grey value where the file has none.
[[nodiscard]] Raster<Rgb> read_colours(const std::filesystem::path& path);

/// Attitude of a gimbal's camera as DJI's XMP has it: yaw clockwise from north, pitch up from the horizon (-90 looks
/// straight down), roll clockwise about the axis of view.
struct GimbalAngles {
  double yaw_deg = 0, pitch_deg = 0, roll_deg = 0;
};

/// What the header says. What it does not say, or says with a fraction over 0, is none.
struct PhotographFacts {
  int width = 0, height = 0;
  bool deep = false;
  std::string camera;              ///< its model, and the band of a multispectral one; may be empty
  std::optional<double> focal_mm;  ///< as EXIF states it, and for 35 mm film
  std::optional<double> focal_film_mm;
  /// Horizontal, from the focal length for 35 mm film, or else from the focal length and the pixels of the sensor.
  std::optional<double> field_of_view_rad;
  std::string lens_fault;                   ///< why there is none although there is a focal length; empty otherwise
  std::optional<std::int64_t> time_ns;      ///< of the exposure, since 1970, as the camera's clock says
  std::optional<std::int64_t> zone_s;       ///< what that clock is ahead of UTC
  std::optional<std::int64_t> gps_time_ns;  ///< of the position, since 1970, UTC
  std::optional<GimbalAngles> gimbal;
  std::optional<double> direction_deg;  ///< in which the image was taken, clockwise from north
  std::optional<GeoTag> place;
  std::string place_fault;  ///< why there is no place although the header has one; empty otherwise
};
[[nodiscard]] PhotographFacts read_photograph_facts(const std::filesystem::path& path);

}  // namespace ilp::host
