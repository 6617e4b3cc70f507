// Motions of the camera that explain the homography of a plane.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// A motion and the plane that together make a homography between normalised coordinates: H ~ R + t plane^T.
struct PlaneMotion {
  RigidTransform b_from_a;    ///< |t| = 1
  Vec3 plane = Vec3::Zero();  ///< points X of frame a on it have plane . X = 1, in baselines
};

struct PlaneSolution {
  PlaneMotion motion;
  std::uint32_t support = 0;  ///< matches on the plane that are in front of both cameras
};

/// Up to two solutions explain a plane: the first belongs to the pose that was found, the second is its rival. There is
/// one solution if points would be invisible for the rival, or if both directions of translation agree to within a
/// degree. There is none without a plane.
struct PlaneSolutions {
  PlaneSolution solution[2];
  std::size_t count = 0;
};

}  // namespace ilp
