// Errors of the intrinsics that a flight is given, relative to the camera that takes its images.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/world/parameter.hpp"

namespace ilp::world {

struct GivenCameraErrors {
  double focal_share = 0;  ///< error of the focal length, as a share of it
  double centre_x_px = 0, centre_y_px = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  /// Factor on additional nearly normal errors that are drawn from the seed. Their sigmas are 3 % of the focal length,
  /// 4 px for each coordinate of the principal point, 0.02 for k1, 0.01 for k2, and 0.0005 for p1 and p2.
  double random = 0;
};

[[nodiscard]] std::vector<Parameter> parameters(GivenCameraErrors& errors);
/// `truth` with the errors added.
[[nodiscard]] CameraModel given_camera(const CameraModel& truth, const GivenCameraErrors& errors, std::uint64_t seed);

}  // namespace ilp::world
