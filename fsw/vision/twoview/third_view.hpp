// A third view decides between the two solutions of a plane (decisions.md, 7).
#pragma once

#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

struct ThirdViewChoice {
  bool decided = false;        ///< false if both planes explain the third view, or neither does
  std::size_t chosen = 0;      ///< index into PlaneSolutions::solution; valid when decided
  std::uint32_t matches = 0;   ///< matches of the third view that lie on one plane
  double excess_px2[2] = {};   ///< sum of squared transfer errors over that of a free homography
  double log_odds = 0;         ///< of the chosen solution against the other one
  RigidTransform c_from_a[2];  ///< over either plane, in baselines; valid if its excess is finite
};

/// Each solution fixes the plane in frame a. Seen by camera c, the plane makes the homography R + t plane^T, which has
/// six parameters instead of eight. The true plane fits the matches (a, c), and the false one does not, unless c stands
/// where a or b stood. `pairs` are matches of images a and c; at least params.min_inliers of them have to lie on one
/// plane. Nothing is decided unless `solutions` holds two. `invalid_argument` for parameters or cameras out of range.
/// Source of the common plane: H. C. Longuet-Higgins, "The Reconstruction of a Plane Surface from Two Perspective
/// Projections", 1986.
Status choose_by_third_view(const PlaneSolutions& solutions, const PointPairs& pairs, const CameraModel& camera_a,
                            const CameraModel& camera_c, const RansacParams& params, TwoViewWorkspace& workspace,
                            ThirdViewChoice& choice);

}  // namespace ilp
