// The pose of one camera from known points that it sees: P3P in RANSAC, then non-linear refinement.
// (M. Fischler, R. Bolles 1981; MSAC scoring: P. Torr, A. Zisserman, "MLESAC", 2000.)
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

struct PointView {
  double position[3] = {0, 0, 0};  ///< world
  double x = 0, y = 0;             ///< ideal px
};
using PointViews = FixedVector<PointView, limits::max_matches>;
using ViewMask = FixedVector<std::uint8_t, limits::max_matches>;

/// Fewer known points do not give a trustworthy pose.
inline constexpr std::uint32_t min_resection_inliers = 15;

struct ResectionParams {
  double threshold_px = 2.0;  ///< inlier bound on the reprojection error; points carry errors of their own
  std::uint32_t max_trials = 300;
  std::uint32_t min_inliers = min_resection_inliers;
  std::uint64_t seed = 1;  ///< made from record ids
  double robust_px = 1.0;  ///< Huber bound of the refinement
};

struct ResectionResult {
  RigidTransform cam_from_world;
  std::uint32_t inliers = 0;
  std::uint32_t trials = 0;
  double rms_px = 0;  ///< of the inliers, per residual coordinate
};

/// `inliers[i]` says whether view i is one. Deterministic for a given seed. `invalid_argument` for non-finite views,
/// `too_few_matches` below min_inliers views, `no_model` when no pose reaches min_inliers, or when the inliers' image
/// points lie within a few thresholds of one line: they fit any turn about it to within their noise.
Status resect(const PointViews& views, const CameraModel& camera, const ResectionParams& params, ViewMask& inliers,
              ResectionResult& result);

}  // namespace ilp
