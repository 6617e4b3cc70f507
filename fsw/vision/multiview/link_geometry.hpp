// Estimates the similarity between the cameras of two keyframes whose worlds have different units, from common
// features.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/multiview/resection.hpp"

namespace ilp {

/// A feature that the earlier keyframe (the place) and the newer one have in common. Inverse depths are along the
/// optical axis; 0: unknown.
struct LinkMatch {
  double place_x = 0, place_y = 0;  ///< ideal px
  double place_inverse_depth = 0;   ///< 1 / world unit of the place's strip
  double x = 0, y = 0;              ///< ideal px
  double inverse_depth = 0;         ///< 1 / world unit of the newer keyframe's strip
};
using LinkMatches = FixedVector<LinkMatch, limits::max_place_patches>;

struct LinkGeometryParams {
  double threshold_px = 4;        ///< inlier threshold; features of coarse levels have errors of a few px
  double feature_sigma_px = 0.6;  ///< one-sigma error of a feature's position
  double depth_sigma = 0.006;     ///< one-sigma error of a feature's depth divided by the depth
  std::uint32_t min_inliers = 12;
  std::uint64_t seed = 1;
};

struct LinkGeometry {
  Similarity keyframe_from_place;   ///< maps camera coordinates of the place to those of the newer keyframe
  SimilarityCovariance covariance;  ///< covariance of a small similarity step in the newer keyframe's camera frame
  std::uint32_t inliers = 0;
  double rms_px = 0;  ///< RMS residual of the inliers, per coordinate
};

struct LinkGeometryWorkspace {
  PointViews views;
  ViewMask inliers;
};

/// Estimates the similarity. It resects the newer camera from the place's points, takes the scale from the depths of
/// the newer keyframe, and then refines both together, so that features and depths of both keyframes agree. The
/// covariance follows from the estimated errors and is enlarged if the residuals are larger. The result is
/// deterministic for a given seed. Returns `too_few_matches` if fewer than min_inliers of the matches that fit the
/// resection have a depth in both keyframes, `no_model` if no similarity has that many inliers.
Status estimate_link(const LinkMatches& matches, const CameraModel& camera, const LinkGeometryParams& params,
                     LinkGeometryWorkspace& workspace, LinkGeometry& geometry);

}  // namespace ilp
