// What the error of a height consists of.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::map {

/// One sigma each, strip units; 0 where nothing is stated.
struct HeightErrorParts {
  double matching = 0;  ///< of the depths: neighbouring cells are nearly independent
  double poses = 0;     ///< of the cameras and the lens: common to the ground that one keyframe shows
  double scale = 0;     ///< of the length of the strip's unit, by the height below the track
  double tilt = 0;      ///< of what is up, by the distance from the middle of the track
  double place = 0;     ///< of the height of the strip as a whole

  /// All of them; they are independent of each other.
  [[nodiscard]] double whole() const;
};

/// The errors of a strip beside those of matching.
struct HeightErrors {
  struct OfKeyframe {
    double centre_z = 0, centre_sigma_z = 0;  ///< strip units; the sigma in the gauge of the strip's first baseline
    double depth_share = 0;                   ///< of a depth, by both poses and the lens
  };
  std::vector<OfKeyframe> keyframes;  ///< by place in the strip
  Vec3 middle = Vec3::Zero();         ///< of the track
  double scale_sigma = 0;             ///< relative
  double tilt_sigma_rad = 0, place_sigma = 0;

  /// Of a height of the map at a point of the strip's world. `source`: 1 + place of the keyframe, 0: none; `matching`
  /// may be NaN, which is not stated.
  [[nodiscard]] HeightErrorParts parts(const Vec3& point, std::uint16_t source, double matching) const;
  /// Of everything in it.
  [[nodiscard]] std::uint64_t digest() const;
};

/// By the records of poses and depths, and by what the vehicle's measurements say of the strip, or its control points
/// if these have placed it.
[[nodiscard]] HeightErrors height_errors_of(const intake::Flight& flight, const intake::Strip& strip);

}  // namespace ilp::map
