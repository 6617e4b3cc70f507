// Whether a flight can be rendered over a terrain: the camera stays above the ground and sees nothing but ground.
#pragma once

#include <span>

#include "fsw/base/geometry.hpp"
#include "sim/world/camera_state.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

/// std::invalid_argument names frame and time at which the camera is not above the highest ground, a corner of its
/// image looks less than about 14 degrees below the horizon, or its image shows more ground than can be held, and which
/// parameters to change.
void check_flight(const Terrain& terrain, const CameraModel& camera, std::span<const CameraState> states);

}  // namespace ilp::world
