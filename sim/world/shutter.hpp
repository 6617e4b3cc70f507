// When a pixel is exposed, and where the camera is then: rolling shutter and motion blur.
#pragma once

#include <cstdint>

#include "sim/world/camera_effects.hpp"
#include "sim/world/camera_state.hpp"

namespace ilp::world {

/// The state `seconds` after motion.state, at the rates of the motion; time_ns stays.
[[nodiscard]] CameraState state_after(const CameraMotion& motion, double seconds);

/// The middle of a row's exposure, seconds after that of the image's middle row.
[[nodiscard]] double row_time_s(const CameraEffects& effects, std::int32_t row, std::int32_t rows);

}  // namespace ilp::world
