// Relative pose of two calibrated views, and a verdict that says whether the matches determine it (decisions.md, 6 and
// 7).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/twoview/robust/ransac_params.hpp"
#include "fsw/vision/twoview/solvers/plane_motion.hpp"
#include "fsw/vision/twoview/solvers/point_pairs.hpp"

namespace ilp {

struct TwoViewResult {
  TwoViewVerdict verdict = TwoViewVerdict::too_few_inliers;
  RigidTransform b_from_a;  ///< translation has unit length
  std::uint32_t inliers = 0;
  double gric_e = 0, gric_h = 0;   ///< GRIC of the essential matrix and of the homography, over the inliers
  double median_parallax_px = 0;   ///< median displacement of the inliers that the rotation does not explain
  double rms_px = 0;               ///< RMS Sampson error of the inliers
  double sigma_rotation_rad = 0;   ///< standard deviation about the worst axis; infinite if undetermined
  double sigma_direction_rad = 0;  ///< the same for the direction of the translation
  /// Motions that explain the homography of the inliers, valid if the verdict is `planar`. If there are two, the pair
  /// cannot decide between them; a third view can (third_view.hpp).
  PlaneSolutions planes;
};

struct TwoViewWorkspace;  // defined in two_view_workspace.hpp

/// Largest accepted standard deviation of the direction of translation (20 degrees). Above it the verdict is
/// `ill_conditioned`.
inline constexpr double largest_sigma_direction_rad = 0.35;

/// Estimates the pose by LO-RANSAC on samples of five matches (five_point.hpp, ransac.hpp), refines it on the inliers,
/// and compares the models by GRIC (gric.hpp). `camera_a` and `camera_b` give the intrinsics of the ideal pixels.
/// `inliers` has one element per match of `pairs`: 1 for an inlier, 0 for an outlier. Matches that are not finite are
/// outliers. The result is the same for the same seed. Returns `invalid_argument` if a camera or a parameter is out of
/// range; a pair without a pose is no error (see TwoViewResult::verdict).
Status estimate_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                         const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                         TwoViewResult& result);

/// estimate_two_view in slices of about 10 ms on a processor of 1000 MIPS: call begin_two_view once, then
/// two_view_slice with the same arguments while it returns true. Do not use the workspace for anything else until it
/// returns false.
Status begin_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                      const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                      TwoViewResult& result);
[[nodiscard]] bool two_view_slice(const CameraModel& camera_a, const CameraModel& camera_b, const RansacParams& params,
                                  TwoViewWorkspace& workspace, InlierMask& inliers, TwoViewResult& result);

}  // namespace ilp
