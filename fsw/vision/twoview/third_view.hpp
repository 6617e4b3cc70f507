// A third view decides between the two solutions of a plane (decisions.md, 7).
#pragma once

#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct ThirdViewChoice {
  bool decided = false;        ///< false if both planes explain the third view, or neither does
  std::size_t chosen = 0;      ///< index into PlaneSolutions::solution; valid when decided
  std::uint32_t matches = 0;   ///< matches (a, c) that lie on one plane
  double excess_px2[2] = {};   ///< sum of squared transfer errors with plane k, minus that with a free homography
  double log_odds = 0;         ///< natural logarithm of the odds of the chosen solution against the other one
  RigidTransform c_from_a[2];  ///< pose of c with plane k, |t| in baselines of (a, b); valid if its excess is finite
};

/// Decides which of two solutions is the true one from the matches `pairs` of images a and c. Each solution fixes the
/// plane in frame a. The plane induces the homography R + t plane^T from a to c, which has six parameters instead of
/// eight. The true plane fits the matches, and the false one does not, unless c has the position of a or b. Nothing is
/// decided if fewer than params.min_inliers matches lie on one plane, or if `solutions` does not hold two. Returns
/// `invalid_argument` if a parameter or a camera is out of range. Source of the common plane: H. C. Longuet-Higgins,
/// "The Reconstruction of a Plane Surface from Two Perspective Projections", 1986.
Status choose_by_third_view(const PlaneSolutions& solutions, const PointPairs& pairs, const CameraModel& camera_a,
                            const CameraModel& camera_c, const RansacParams& params, TwoViewWorkspace& workspace,
                            ThirdViewChoice& choice);

}  // namespace ilp
