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
/// is then their mean correlation. Otherwise the verdict is overlap_unknown. `seed`: of the search for the plane.
Status measure_overlap_by_features(GrayView image_a, GrayView image_b, std::uint64_t seed,
                                   FeatureOverlapWorkspace& workspace, OverlapResult& result);

}  // namespace ilp
