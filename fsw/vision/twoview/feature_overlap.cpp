#include "fsw/vision/twoview/feature_overlap.hpp"

#include <cmath>

#include "fsw/vision/twoview/robust/robust_models.hpp"

namespace ilp {
namespace {

// How far a corner may have moved, as a share of the image's width.
constexpr double search_share = 0.35;
// Wide, because relief bends the ground's plane.
constexpr double plane_threshold_px = 6;
// So many matches must agree on one plane. In unrelated images 2 to 3 % of the corners match by chance, and a handful
// of these agree.
constexpr std::uint32_t least_on_plane = 40;
constexpr double least_share_on_plane = 0.25;

}  // namespace

Status measure_overlap_by_features(GrayView image_a, GrayView image_b, std::uint64_t seed, FeatureOverlapWorkspace& w,
                                   OverlapResult& result) {
  result = {};
  result.verdict = OverlapVerdict::overlap_unknown;
  const HarrisParams harris;
  ILP_TRY(detect_corners(image_a, harris, w.harris, w.corners_a));
  ILP_TRY(detect_corners(image_b, harris, w.harris, w.corners_b));
  MatcherParams matcher;
  matcher.search_radius_px = static_cast<float>(search_share * image_a.width);
  ILP_TRY(match_corners(image_a, w.corners_a, image_b, w.corners_b, Similarity2{}, matcher, w.matcher, w.matches));

  w.pairs.clear();
  for (const Match& match : w.matches) {
    const Corner& a = w.corners_a[match.a];
    const PointPair pair{static_cast<double>(a.x), static_cast<double>(a.y), static_cast<double>(match.xb),
                         static_cast<double>(match.yb), match.score};
    ILP_ASSERT(w.pairs.push_back(pair), w.pairs.size());
  }
  RansacParams ransac;
  ransac.threshold_px = plane_threshold_px;
  ransac.min_inliers = least_on_plane;
  ransac.seed = seed;
  HomographyResult plane;
  ILP_TRY(estimate_homography(w.pairs, ransac, w.two_view, w.inliers, plane));
  const double share = static_cast<double>(plane.inliers) / static_cast<double>(w.pairs.size() + 1);
  if (!plane.found || share < least_share_on_plane || std::fabs(plane.homography(2, 2)) < 1e-12) return {};

  double score = 0;
  for (std::size_t i = 0; i < w.matches.size(); ++i) {
    if (w.inliers[i] != 0) score += static_cast<double>(w.matches[i].score);
  }
  result.ncc = score / plane.inliers;
  result.sigma_px = plane.rms_px;
  for (int i = 0; i < 9; ++i) result.plane_b_from_a[i] = plane.homography(i / 3, i % 3) / plane.homography(2, 2);
  result.b_from_a = similarity_at_centre(image_a.width, image_a.height, result.plane_b_from_a);
  result.overlap = footprint_overlap_of_plane(image_a.width, image_a.height, result.plane_b_from_a);
  result.verdict = OverlapVerdict::ok;
  return {};
}

}  // namespace ilp
