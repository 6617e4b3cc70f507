// Converts a user's photographs to images that the flight's camera can read: JPEG, TIFF, 16 bits, more pixels than the
// flight takes, blanks in paths. Writes their EXIF positions as measurements of the vehicle.
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

/// Attitude of the camera as a photograph states it.
struct StatedAttitude {
  std::optional<host::GimbalAngles> gimbal;
  std::optional<double> direction_deg;  ///< azimuth of the line of sight, clockwise from north
};

struct FlyableImages {
  std::vector<host::StripFrame> frames;
  host::ImageSize source;                           ///< original size of the photographs; 0 x 0: none can be read
  int binning = 1;                                  ///< pixels of the source, in x and in y, that become one
  std::optional<double> field_of_view_rad;          ///< horizontal, of the first image that states it
  std::string lens_fault;                           ///< why a focal length in EXIF is not used
  std::vector<std::optional<host::GeoTag>> places;  ///< of each frame; empty if EXIF states none
  std::vector<StatedAttitude> attitudes;            ///< of each frame
  std::optional<StripEpoch> epoch;                  ///< empty if the times are not those of EXIF
};

/// Prepares a strip. Images that the flight can read as they are stay where they are. The others become 8-bit PNG files
/// in `folder`, named by host::image_key. 16-bit values are scaled by the common range of the strip. Assumed times are
/// replaced by EXIF times (take_stated_times). Photographs of another size, sensor or focal length than most are left
/// out (keep_one_camera, with `of_camera` the size in the camera file). Damaged photographs are left out as well,
/// except PNG and PGM files, which the flight reports itself. `messages` gets a line for every change.
[[nodiscard]] FlyableImages make_flyable(const std::vector<host::StripFrame>& strip,
                                         const std::filesystem::path& folder, std::ostream& messages,
                                         const std::optional<host::ImageSize>& of_camera = {});

/// Fewer positions do not determine where a strip lies and how it is rotated.
inline constexpr std::size_t fewest_places = 3;

struct PlaceOptions {
  double sigma_m = 5;  ///< of a position without an estimated error; elevations have twice the sigma of their position
  bool looks_down = true;  ///< straight down to 0.1 rad (one sigma); gives the vertical, which positions do not
};

/// Quaternion (w, x, y, z) of a camera on a gimbal: x_camera = q x_level q*, with the level frame east, north, up.
[[nodiscard]] std::array<double, 4> attitude_of(const host::GimbalAngles& gimbal);

/// Writes positions and gimbal attitudes as the vehicle's measurements (docs/navigation.md), at the times of the
/// frames. `looks_down` is ignored if any image has gimbal angles. Returns false and writes nothing for fewer than
/// `fewest_places` positions. Throws std::runtime_error if the file cannot be written.
bool write_places(const FlyableImages& images, const PlaceOptions& options, const std::filesystem::path& file,
                  std::ostream& messages);

/// The camera of images in which `binning` x `binning` pixels have become one.
[[nodiscard]] CameraModel binned_camera(const CameraModel& camera, int binning);

}  // namespace ilp::sil
