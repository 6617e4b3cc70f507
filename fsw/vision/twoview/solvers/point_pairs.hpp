// The matches of two images, as input of the estimators.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"

namespace ilp {

/// One putative match in ideal pixels (distortion removed; fsw/vision/geometry/camera.hpp).
struct PointPair {
  double xa = 0, ya = 0;  ///< ideal px in image a
  double xb = 0, yb = 0;  ///< ideal px in image b
  float quality = 0;      ///< larger is better; orders the samples (PROSAC)
};
using PointPairs = FixedVector<PointPair, limits::max_matches>;
/// One element per match, in their order: 1 for an inlier, 0 for an outlier.
using InlierMask = FixedVector<std::uint8_t, limits::max_matches>;

}  // namespace ilp
