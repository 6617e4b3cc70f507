// The motions that the image of a plane leaves possible.
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

/// Up to two: the first goes with the pose found, the second is its rival. One where visibility refutes the rival or
/// where the two are the same to within a degree; none without a plane.
struct PlaneSolutions {
  PlaneSolution solution[2];
  std::size_t count = 0;
};

}  // namespace ilp
