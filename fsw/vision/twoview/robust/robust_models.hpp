// Robust estimates of the fundamental matrix and the homography of two uncalibrated views, and the GRIC that shows
// which of them the matches support (decisions.md, 6). On a plane the fundamental matrix fits as well as the homography
// but is meaningless: trust it only if its GRIC is clearly smaller.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "fsw/vision/twoview/robust/ransac_params.hpp"
#include "fsw/vision/twoview/solvers/point_pairs.hpp"

namespace ilp {

struct TwoViewWorkspace;  // two_view_workspace.hpp

struct FundamentalResult {
  bool found = false;
  Mat3 fundamental = Mat3::Zero();  ///< ideal px, b^T F a = 0, unit norm, rank 2
  std::uint32_t inliers = 0;
  double rms_px = 0;           ///< Sampson error of the inliers
  double gric = 0;             ///< over all finite matches
  double gric_inliers = 0;     ///< over the inliers only; compare it with gric_homography
  double gric_homography = 0;  ///< GRIC of the inliers' best homography, over the inliers
};

struct HomographyResult {
  bool found = false;
  Mat3 homography = Mat3::Zero();  ///< ideal px, x_b ~ H x_a, unit norm
  std::uint32_t inliers = 0;
  double rms_px = 0;  ///< transfer error of the inliers
  double gric = 0;    ///< over all finite matches
};

/// 7-point LO-RANSAC, then non-linear refinement. `found` is false if there are fewer than params.min_inliers or 8
/// inliers. Returns `invalid_argument` if a parameter is out of range.
Status estimate_fundamental(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                            InlierMask& inliers, FundamentalResult& result);

/// 4-point LO-RANSAC on the transfer error, then non-linear refinement. `found` is false if there are fewer than
/// params.min_inliers or 5 inliers. Returns `invalid_argument` if a parameter is out of range.
Status estimate_homography(const PointPairs& pairs, const RansacParams& params, TwoViewWorkspace& workspace,
                           InlierMask& inliers, HomographyResult& result);

}  // namespace ilp
