// Scratch of estimate_two_view, estimate_fundamental and estimate_homography. It is too large for a stack: make it
// static.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/robust/ransac.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// State of estimate_two_view between two slices.
struct TwoViewProgress {
  enum class Part : std::uint8_t { search, support, plane, compare, mirror, judge, turn };
  Part part = Part::search;
  bool plane_found = false;
  RansacRun<RigidTransform> poses;
  RansacRun<Mat3> planes;
  RigidTransform pose;
  double rival_excess_px2 = 0;  ///< cost of the motion with the opposite turn, minus that of `pose`
  RansacScore best;
  Mat3 homography = Mat3::Identity();
};

struct TwoViewWorkspace {
  TwoViewProgress progress;
  NormalisedPairs pairs;   ///< all finite matches
  NormalisedPairs subset;  ///< matches that support the epipolar geometry, for the search of a homography
  FixedVector<std::uint16_t, limits::max_matches> selected;         ///< indices into `pairs`
  FixedVector<std::uint16_t, limits::max_matches> subset_selected;  ///< indices into `subset`
  FixedVector<double, limits::max_matches> scratch;
};

}  // namespace ilp
