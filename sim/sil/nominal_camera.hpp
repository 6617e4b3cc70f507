// Cameras with unmeasured intrinsics, for flights that have to find them.
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"

namespace ilp::sil {

/// The camera of a data sheet for a camera whose images are those of `truth`: the focal length up to 15 % off, the
/// principal point up to 1 % of the image's width on each axis, drawn from the seed. Distortion bends the same pixels:
/// it must be known.
[[nodiscard]] CameraModel nominal_camera(const CameraModel& truth, std::uint64_t seed);

}  // namespace ilp::sil
