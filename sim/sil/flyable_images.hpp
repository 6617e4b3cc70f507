// Makes images that the flight's camera can read from those that users have: JPEG, TIFF, 16 bits, more pixels than the
// flight takes, blanks in paths.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/strip.hpp"
#include "sim/sil/stated_times.hpp"

namespace ilp::sil {

/// What a photograph says of where its camera looked.
struct StatedAttitude {
  std::optional<host::GimbalAngles> gimbal;
  std::optional<double> direction_deg;  ///< of the image, clockwise from north
};

struct FlyableImages {
  std::vector<host::StripFrame> frames;
  host::ImageSize source;                   ///< size of the photographs that fly, as they came; 0: none can be read
  int binning = 1;                          ///< so many pixels of the source, in x and in y, are one of the flight
  std::optional<double> field_of_view_rad;  ///< horizontal, where the first image states it
  std::string lens_fault;                   ///< why a focal length in EXIF is not used
  std::vector<std::optional<host::GeoTag>> places;  ///< of each frame, where EXIF states it
  std::vector<StatedAttitude> attitudes;            ///< of each frame
  std::optional<StripEpoch> epoch;                  ///< where the times are those that EXIF states
};

/// Images that fly as they are keep their place; the others become 8-bit PNG files in `folder`, under their own names
/// or those that the flight can carry (host::image_key). 16-bit values are scaled by the range of the whole strip.
/// Times that are assumed are replaced by those that EXIF states (take_stated_times). Photographs of another size,
/// sensor or focal length than most are left out (keep_one_camera, with the size of the camera file). Says in
/// `messages` what was done. A damaged photograph is left out by name. PNG and PGM files that fly as they are stay: the
/// flight itself reports damaged or missing ones.
[[nodiscard]] FlyableImages make_flyable(const std::vector<host::StripFrame>& strip,
                                         const std::filesystem::path& folder, std::ostream& messages,
                                         const std::optional<host::ImageSize>& of_camera = {});

/// Fewer do not say where a strip lies and how it is turned.
inline constexpr std::size_t fewest_places = 3;

struct PlaceOptions {
  double sigma_m = 5;      ///< one sigma of a position without an estimated error; twice as much of an elevation
  bool looks_down = true;  ///< the camera does, to 0.1 rad (one sigma): positions alone do not say what is up
};

/// Quaternion x_camera = q x_level q* of a camera on a gimbal; level is east, north, up. w, x, y, z.
[[nodiscard]] std::array<double, 4> attitude_of(const host::GimbalAngles& gimbal);

/// Writes the places as the vehicle's measurements (docs/navigation.md), at the times of the frames, with the attitude
/// that a gimbal states. Where one image has a gimbal's angles, no other is taken to look straight down. False, and
/// nothing is written, for fewer than `fewest_places`. Throws std::runtime_error.
bool write_places(const FlyableImages& images, const PlaceOptions& options, const std::filesystem::path& file,
                  std::ostream& messages);

/// The camera of images whose pixels are joined, `binning` by `binning`.
[[nodiscard]] CameraModel binned_camera(const CameraModel& camera, int binning);

}  // namespace ilp::sil
