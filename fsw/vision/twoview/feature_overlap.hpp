// Measures the overlap of two images from matched corners. It is for images that do not correlate, because the views
// are far apart or the ground has much relief.
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

/// Below this NCC of measure_overlap(), the ground is not flat or the views are far apart. The overlap may be right,
/// but its mapping predicts corners too inaccurately.
inline constexpr double weak_correlation = 0.6;

struct FeatureOverlapWorkspace {
  FeatureOverlapWorkspace() : harris() {}

  /// The detection of corners ends before the matching begins.
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

/// Finds the plane on which most matches of corners agree. If enough agree, the verdict is `ok`, `ncc` is their mean
/// correlation, and `sigma_px` their RMS transfer error; overlap, `b_from_a` and the plane's homography are set.
/// Otherwise the verdict is `overlap_unknown`. `seed` selects the random samples of matches. Returns the errors of
/// detect_corners(), match_corners() and estimate_homography().
Status measure_overlap_by_features(GrayView image_a, GrayView image_b, std::uint64_t seed,
                                   FeatureOverlapWorkspace& workspace, OverlapResult& result);

}  // namespace ilp
