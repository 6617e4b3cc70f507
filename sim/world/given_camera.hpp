// How the camera that a flight is given differs from the one that takes its images.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

struct GivenCameraErrors {
  double focal_share = 0;  ///< of the focal length
  double centre_x_px = 0, centre_y_px = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  /// Adds errors drawn from the seed, times this: one sigma is 3 % of the focal length, 4 px of the principal point,
  /// 0.02 of k1, 0.01 of k2, 0.0005 of p1 and p2.
  double random = 0;
};

[[nodiscard]] std::vector<Parameter> parameters(GivenCameraErrors& errors);
[[nodiscard]] CameraModel given_camera(const CameraModel& truth, const GivenCameraErrors& errors, std::uint64_t seed);

}  // namespace ilp::world
