// Makes images that the flight's camera can read from those that users have: JPEG, TIFF, 16 bits, more pixels than the
// flight takes, blanks in paths.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/host/photograph.hpp"
#include "sim/host/strip.hpp"

namespace ilp::sil {

struct FlyableImages {
  std::vector<host::StripFrame> frames;
  int binning = 1;                          ///< so many pixels of the source, in x and in y, are one of the flight
  std::optional<double> field_of_view_rad;  ///< horizontal, where the first image states it
  std::vector<std::optional<host::GeoTag>> places;  ///< of each frame, where EXIF states it
};

/// Images that fly as they are keep their place; the others become 8-bit PNG files in `folder`, under their own names.
/// 16-bit values are scaled by the range of the whole strip. Times that are assumed are replaced by those that all
/// images state, if these increase. Photographs with another focal length than most are left out. Says in `messages`
/// what was done. An image that cannot be read is left as it is: the flight itself reports it.
[[nodiscard]] FlyableImages make_flyable(const std::vector<host::StripFrame>& strip,
                                         const std::filesystem::path& folder, std::ostream& messages);

/// Fewer do not say where a strip lies and how it is turned.
inline constexpr std::size_t fewest_places = 3;

struct PlaceOptions {
  double sigma_m = 5;      ///< one sigma of a position without a stated error; twice as much of an elevation
  bool looks_down = true;  ///< the camera does, to 0.1 rad (one sigma): positions alone do not say what is up
};

/// Writes the places as the vehicle's measurements (docs/navigation.md), at the times of the frames. False, and nothing
/// is written, for fewer than `fewest_places`. Throws std::runtime_error.
bool write_places(const FlyableImages& images, const PlaceOptions& options, const std::filesystem::path& file,
                  std::ostream& messages);

/// The camera of images whose pixels are joined, `binning` by `binning`.
[[nodiscard]] CameraModel binned_camera(const CameraModel& camera, int binning);

}  // namespace ilp::sil
