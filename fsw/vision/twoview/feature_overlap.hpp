// A second opinion on the overlap of two images, by features: for views so far apart, or ground so deep, that no window
// of one image correlates with the other as a whole.
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

struct FeatureOverlapParams {
  std::int32_t corners = 1000;
  double search_share = 0.35;     ///< of the image's width: how far a corner may have moved
  double plane_threshold_px = 6;  ///< relief bends the ground's plane: wide
  /// Matches that must agree on one plane. Unrelated images give 2 to 3 % of the corners as chance matches, of which a
  /// handful agree.
  std::uint32_t min_inliers = 40;
  double min_inlier_share = 0.25;
  std::uint64_t seed = 1;
};

struct FeatureOverlapWorkspace {
  HarrisWorkspace harris;
  MatcherWorkspace matcher;
  TwoViewWorkspace two_view;
  Corners corners_a, corners_b;
  Matches matches;
  PointPairs pairs;
  InlierMask inliers;
};

/// Verdict ok with the overlap and the plane's homography when enough corner matches agree on one plane, else
/// overlap_unknown; `ncc` is then the mean correlation of the matches and `b_from_a` stays the identity.
Status measure_overlap_by_features(GrayView image_a, GrayView image_b, const FeatureOverlapParams& params,
                                   FeatureOverlapWorkspace& workspace, OverlapResult& result);

}  // namespace ilp
