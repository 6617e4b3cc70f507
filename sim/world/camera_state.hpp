// Where a simulated camera is, and how it moves while the shutter is open.
#pragma once

#include <cstdint>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::world {

struct CameraState {
  std::int64_t time_ns = 0;
  Mat3 rotation = Mat3::Identity();  ///< cam_from_world: x_cam = rotation (X - centre)
  Vec3 centre = Vec3::Zero();        ///< m
};

/// A state and its rates, good for as long as an exposure lasts.
struct CameraMotion {
  CameraState state;                 ///< in the middle of the exposure of the image's middle row
  Vec3 velocity_m_s = Vec3::Zero();  ///< in the world
  Vec3 turn_rad_s = Vec3::Zero();    ///< in the camera: rotation after dt is exp([turn dt]x) rotation
};

}  // namespace ilp::world
