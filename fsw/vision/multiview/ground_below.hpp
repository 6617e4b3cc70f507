// Distance of the ground below a camera, from the structure's points near the camera's vertical.
#pragma once

#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

struct GroundBelow {
  double distance = 0;  ///< distance from the camera along the world's z axis, world units
  double sigma = 0;     ///< one-sigma error from the scatter of the points, world units
};

/// Fits a plane, without outliers, to the points below the camera that are nearest to its vertical, and intersects it
/// with the vertical. `centre` is the camera's position in the world; z points up. Returns false if there are too few
/// points, or too few within a third of the distance from the vertical.
[[nodiscard]] bool ground_below(const Tracks& tracks, const double (&centre)[3], GroundBelow& ground);

}  // namespace ilp
