// Relative pose of two calibrated views, with the verdict on what the pair can tell (decisions.md, 6 and 7).
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
  double gric_e = 0, gric_h = 0;
  double median_parallax_px = 0;
  double rms_px = 0;               ///< Sampson error of the inliers
  double sigma_rotation_rad = 0;   ///< one sigma, worst axis, from the normal equations and rms_px
  double sigma_direction_rad = 0;  ///< one sigma of the translation's direction, worst axis
  /// Of the plane nearest to the inliers, meant when the verdict is planar. Two: the pose is one of two that explain
  /// the pair equally; a third view tells (third_view.hpp).
  PlaneSolutions planes;
};

struct TwoViewWorkspace;  // defined in two_view_workspace.hpp
/// 5-point LO-RANSAC with refinement on the inliers (see five_point.hpp, ransac); GRIC of F and H by gric.hpp. Matches
/// that are not finite are outliers.
/// `camera_a` and `camera_b` give the intrinsics of the ideal pixels. Deterministic for a given seed.
Status estimate_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                         const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                         TwoViewResult& result);

}  // namespace ilp
