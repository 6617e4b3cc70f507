// Resection: the pose of one camera from known points that it sees, by P3P in RANSAC and non-linear refinement. (M.
// Fischler, R. Bolles 1981; MSAC scoring: P. Torr, A. Zisserman, "MLESAC", 2000.)
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

/// Least number of inliers of a trustworthy pose.
inline constexpr std::uint32_t min_resection_inliers = 15;

struct ResectionParams {
  double threshold_px = 2.0;  ///< inlier threshold of the reprojection error; includes the errors of the points
  std::uint32_t max_trials = 300;
  std::uint32_t min_inliers = min_resection_inliers;
  std::uint64_t seed = 1;  ///< made from record ids
  double robust_px = 1.0;  ///< bound of the Huber loss in the refinement
};

struct ResectionResult {
  RigidTransform cam_from_world;
  std::uint32_t inliers = 0;
  std::uint32_t trials = 0;
  double rms_px = 0;  ///< RMS residual of the inliers, per coordinate
};

/// Computes the pose. `inliers[i]` is nonzero if view i is an inlier. The result is deterministic for a given seed.
/// Returns `invalid_argument` if a view is not finite, `too_few_matches` if there are fewer than min_inliers views,
/// `no_model` if no pose reaches min_inliers. It also returns `no_model` if the image points of the inliers lie within
/// a few thresholds of one line: they would fit any rotation about that line within their noise.
Status resect(const PointViews& views, const CameraModel& camera, const ResectionParams& params, ViewMask& inliers,
              ResectionResult& result);

}  // namespace ilp
