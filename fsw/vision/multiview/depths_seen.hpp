// How near and how far the points of a strip are that a camera sees.
#pragma once

#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

/// Along the optical axis, world units.
struct DepthsSeen {
  double least = 0, largest = 0;
};

/// The depths of the points that `camera` observes, without the fiftieth part at either end. False for fewer than ten
/// points. `scratch` receives the depths.
[[nodiscard]] bool depths_seen(const SequenceState& sequence, const SequenceCamera& camera,
                               FixedVector<float, limits::max_tracks>& scratch, DepthsSeen& seen);

}  // namespace ilp
