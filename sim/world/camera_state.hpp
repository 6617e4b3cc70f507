// Pose of a simulated camera, and its motion while the shutter is open.
#pragma once

#include <cstdint>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::world {

struct CameraState {
  std::int64_t time_ns = 0;
  Mat3 rotation = Mat3::Identity();  ///< cam_from_world: x_cam = rotation (X - centre)
  Vec3 centre = Vec3::Zero();        ///< m
};

/// A state and its rates, which are taken as constant during an exposure.
struct CameraMotion {
  CameraState state;                 ///< at the middle of the exposure of the image's middle row
  Vec3 velocity_m_s = Vec3::Zero();  ///< in the world frame
  Vec3 turn_rad_s = Vec3::Zero();    ///< in the camera frame: rotation after dt is exp([turn dt]x) rotation
};

}  // namespace ilp::world
