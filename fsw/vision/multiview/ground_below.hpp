// How far below a camera the ground is, by the points of the structure near the place straight below it.
#pragma once

#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

struct GroundBelow {
  double distance = 0;  ///< along the world's z axis, world units
  double sigma = 0;     ///< one sigma by the scatter of the points, world units
};

/// A plane through the points nearest to the camera's vertical, without outliers. False if there are too few points,
/// or none as near as a third of the distance.
[[nodiscard]] bool ground_below(const Tracks& tracks, const double (&centre)[3], GroundBelow& ground);

}  // namespace ilp
