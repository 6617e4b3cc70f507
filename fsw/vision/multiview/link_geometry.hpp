// The similarity between the cameras of two keyframes whose worlds have different units, from features that they have
// in common.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "fsw/vision/multiview/resection.hpp"

namespace ilp {

/// A feature of the earlier keyframe (the place) and of the newer one. An inverse depth of 0 means that it is unknown.
struct LinkMatch {
  double place_x = 0, place_y = 0;  ///< ideal px
  double place_inverse_depth = 0;   ///< 1 / unit of the place's strip
  double x = 0, y = 0;              ///< ideal px
  double inverse_depth = 0;         ///< 1 / unit of the newer keyframe's strip
};
using LinkMatches = FixedVector<LinkMatch, limits::max_place_patches>;

struct LinkGeometryParams {
  double threshold_px = 4;        ///< inlier bound; features of coarse levels lie within a few px
  double feature_sigma_px = 0.6;  ///< one-sigma error of a feature's place
  double depth_sigma = 0.006;     ///< relative one-sigma error of the depth of a feature
  std::uint32_t min_inliers = 12;
  std::uint64_t seed = 1;
};

struct LinkGeometry {
  Similarity keyframe_from_place;   ///< camera coordinates of both
  SimilarityCovariance covariance;  ///< of a step in the newer keyframe's camera frame
  std::uint32_t inliers = 0;
  double rms_px = 0;  ///< of the inliers, per residual coordinate
};

struct LinkGeometryWorkspace {
  PointViews views;
  ViewMask inliers;
};

/// Starts from the resection of the newer camera on the place's points, takes the scale from the depths of the newer
/// keyframe, and refines both together over the features in the other image and their depths. The covariance follows
/// from the estimated errors, enlarged when the residuals are larger. Deterministic for a given seed. `too_few_matches`
/// when fewer than min_inliers matches have a depth in each keyframe, `no_model` when no similarity has that many
/// inliers.
Status estimate_link(const LinkMatches& matches, const CameraModel& camera, const LinkGeometryParams& params,
                     LinkGeometryWorkspace& workspace, LinkGeometry& geometry);

}  // namespace ilp
