// Components of the standard deviation of a map height.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::map {

/// Standard deviations in strip units. 0: unknown, so that the total does not contain it.
struct HeightErrorParts {
  double matching = 0;  ///< from the matching of the depth maps; nearly independent between cells
  double poses = 0;     ///< from camera poses and lens; common to all ground of one keyframe
  double scale = 0;     ///< from the strip's scale: relative sigma times vertical distance from the track's centre
  double tilt = 0;      ///< from the vertical direction: sigma in rad times horizontal distance from the centre
  double place = 0;     ///< from the vertical offset of the whole strip

  /// Root of the sum of squares; the components are independent of each other.
  [[nodiscard]] double whole() const;
};

/// What the components of a strip's height errors are computed from, except the errors of matching.
struct HeightErrors {
  struct OfKeyframe {
    /// z of the camera centre and its standard deviation, strip units; the sigma is in the gauge of the first baseline.
    double centre_z = 0, centre_sigma_z = 0;
    double depth_share = 0;  ///< relative depth error (one sigma) from the poses of both images and the lens
  };
  std::vector<OfKeyframe> keyframes;  ///< in the order of the strip; all 0 for a keyframe without a final pose
  Vec3 middle = Vec3::Zero();         ///< mean of the camera centres: the track's centre, strip units
  // Standard deviations of scale (relative), vertical direction and vertical offset (strip units); 0: unknown.
  double scale_sigma = 0;
  double tilt_sigma_rad = 0, place_sigma = 0;

  /// Components for a map height at `point` in the strip's world. `source`: 1 + index of the keyframe in the strip, 0:
  /// none. `matching`: standard deviation from matching, strip units; NaN: unknown.
  [[nodiscard]] HeightErrorParts parts(const Vec3& point, std::uint16_t source, double matching) const;
  /// Digest of all members.
  [[nodiscard]] std::uint64_t digest() const;
};

/// Collects the errors of a strip. Those of the keyframes come from the records of poses and depths. Those of the strip
/// come from its control points if these have placed it, else from the record of its frame (the vehicle's navigation).
/// With neither, only the error of the scale is known, and only if an altimeter has set the scale.
[[nodiscard]] HeightErrors height_errors_of(const intake::Flight& flight, const intake::Strip& strip);

}  // namespace ilp::map
