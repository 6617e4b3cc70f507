// Cameras with unmeasured intrinsics, for flights that have to find them.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp::sil {

/// The camera of a data sheet for a camera whose images are those of `truth`: the focal length up to 15 % off, the
/// principal point up to 1 % of the image's width on each axis, drawn from the seed. Distortion bends the same pixels:
/// it must be known.
[[nodiscard]] CameraModel nominal_camera(const CameraModel& truth, std::uint64_t seed);

/// The camera assumed for images without a camera file: a horizontal field of view of 60 degrees, the principal point
/// in the middle, no distortion.
[[nodiscard]] CameraModel guessed_camera(std::int32_t width, std::int32_t height);

}  // namespace ilp::sil
