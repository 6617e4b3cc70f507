// Nominal intrinsics with errors, for flights that have to find the intrinsics themselves.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp::sil {

/// Draws a nominal camera for images of the camera `truth`. The error of the focal length is uniform up to 15 %, the
/// error of the principal point up to 1 % of the image's width on each axis. The distortion moves pixels as that of
/// `truth` does, because the flight does not estimate it.
[[nodiscard]] CameraModel nominal_camera(const CameraModel& truth, std::uint64_t seed);

}  // namespace ilp::sil
