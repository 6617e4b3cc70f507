// The overlap of two images by matched corners. It serves where no window of one image correlates with the other one as
// a whole, because the views are far apart or the ground has much relief.
#pragma once

#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/two_view.hpp"

namespace ilp {

/// With a smaller NCC the ground is no plane, or the views are far apart: the overlap by correlation may be right, but
/// the prediction of corners is not accurate enough.
inline constexpr double weak_correlation = 0.6;

struct FeatureOverlapParams {
  std::int32_t corners = 1000;
  double search_share = 0.35;     ///< how far a corner may have moved, as a share of the image's width
  double plane_threshold_px = 6;  ///< wide, because relief bends the ground's plane
  /// This many matches must agree on one plane. In unrelated images 2 to 3 % of the corners match by chance, and a
  /// handful of these agree.
  std::uint32_t min_inliers = 40;
  double min_inlier_share = 0.25;
  std::uint64_t seed = 1;
};

struct FeatureOverlapWorkspace {
  FeatureOverlapWorkspace() : harris() {}

  /// Corners are found before they are matched.
  union {
    HarrisWorkspace harris;
    MatcherWorkspace matcher;
  };
  TwoViewWorkspace two_view;
  Corners corners_a, corners_b;
  Matches matches;
  PointPairs pairs;
  InlierMask inliers;
};

/// The verdict is ok, with overlap, `b_from_a` and the plane's homography, if enough matches agree on one plane; `ncc`
/// is then their mean correlation. Otherwise the verdict is overlap_unknown.
Status measure_overlap_by_features(GrayView image_a, GrayView image_b, const FeatureOverlapParams& params,
                                   FeatureOverlapWorkspace& workspace, OverlapResult& result);

}  // namespace ilp
