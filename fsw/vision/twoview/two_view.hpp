// Relative pose of two calibrated views, and a verdict on what the pair can tell (decisions.md, 6 and 7).
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
  double sigma_direction_rad = 0;  ///< one sigma of the translation's direction, worst axis; infinite if it is open
  /// The solutions of the plane nearest to the inliers, valid when the verdict is planar. If there are two, they
  /// explain the pair equally well, and a third view decides (third_view.hpp).
  PlaneSolutions planes;
};

struct TwoViewWorkspace;  // defined in two_view_workspace.hpp

/// A pose of which the direction of translation is less sure is as good as unknown: 20 degrees, one sigma.
inline constexpr double largest_sigma_direction_rad = 0.35;

/// LO-RANSAC on five matches (five_point.hpp, ransac.hpp), refined on the inliers; gric.hpp compares the models.
/// Matches that are not finite are outliers. `camera_a` and `camera_b` give the intrinsics of the ideal pixels. The
/// result is the same for the same seed.
Status estimate_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                         const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                         TwoViewResult& result);

/// The same in slices of about 10 ms on a processor of 1000 MIPS: one call of begin_two_view, then of two_view_slice,
/// with the same arguments, while it says that there is more. The workspace must not be used otherwise meanwhile.
Status begin_two_view(const PointPairs& pairs, const CameraModel& camera_a, const CameraModel& camera_b,
                      const RansacParams& params, TwoViewWorkspace& workspace, InlierMask& inliers,
                      TwoViewResult& result);
[[nodiscard]] bool two_view_slice(const CameraModel& camera_a, const CameraModel& camera_b, const RansacParams& params,
                                  TwoViewWorkspace& workspace, InlierMask& inliers, TwoViewResult& result);

}  // namespace ilp
