// Range of the depths of a strip's points in one camera.
#pragma once

#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {

/// Depths along the optical axis, world units.
struct DepthsSeen {
  double least = 0, largest = 0;
};

/// Computes the least and the largest depth of the points that `camera` observes, without the smallest and the largest
/// 2 %. Returns false if there are fewer than ten points. `scratch` receives the sorted depths.
[[nodiscard]] bool depths_seen(const SequenceState& sequence, const SequenceCamera& camera,
                               FixedVector<float, limits::max_tracks>& scratch, DepthsSeen& seen);

}  // namespace ilp
