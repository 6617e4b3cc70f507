// Averages the poses that fit a motion towards a point that the camera sees. Near the epipole, noise decides where a
// match lies on its epipolar line. The cost therefore has many local minima, with the epipole between different
// matches, in a valley several degrees wide. The lowest minimum is not the nearest to the truth. Sources: J. Oliensis,
// "The least-squares error for structure from infinitesimal motion", IJCV 2005; A. Chiuso, R. Brockett, S. Soatto,
// "Optimal structure from motion", IJCV 2000.
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

/// True if an epipole lies within its image.
[[nodiscard]] bool epipole_in_view(const RigidTransform& b_from_a, const CameraModel& camera_a,
                                   const CameraModel& camera_b);

/// RMS angles between the minima and their mean.
struct MotionSpread {
  double rotation_rad = 0;
  double direction_rad = 0;
};

/// Looks for the minima around `b_from_a`, which is one of them, and replaces it by their mean, weighted by their
/// likelihood: no other estimate has a smaller expected squared error. Returns the spread of the minima. If the mean
/// itself is unlikely, the minima do not lie in one valley, and `b_from_a` stays. `bound_px` is the bound of Tukey's
/// loss, `sigma_px` the standard deviation of the matches; nothing changes if it is 0.
MotionSpread average_over_minima(const NormalisedPairs& pairs, double bound_px, double sigma_px, PairIndices& scratch,
                                 RigidTransform& b_from_a);

}  // namespace ilp
