// Scratch of estimate_two_view, estimate_fundamental and estimate_homography: keep it static, it is too large for a
// stack.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

struct TwoViewWorkspace {
  NormalisedPairs pairs;   ///< all finite matches
  NormalisedPairs subset;  ///< those that support the epipolar geometry; a homography is searched among them
  FixedVector<std::uint16_t, limits::max_matches> selected;         ///< indices into `pairs`
  FixedVector<std::uint16_t, limits::max_matches> subset_selected;  ///< indices into `subset`
  FixedVector<double, limits::max_matches> scratch;
};

}  // namespace ilp
