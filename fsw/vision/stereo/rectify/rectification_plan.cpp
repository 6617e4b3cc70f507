#include "fsw/vision/stereo/rectify/rectification_plan.hpp"

#include "fsw/base/status_values.hpp"
#include "fsw/vision/stereo/rectify/polar_rectification.hpp"

namespace ilp {

Status plan_panels(const CameraModel& camera, const RigidTransform& left_from_world,
                   const RigidTransform& right_from_world, const DepthRange& depth, const RectificationParams& params,
                   RectificationPlan& plan) {
  RectifiedPanel& first = plan.panels[0];
  plan.count = 0;
  const Status planned =
      plan_rectification(camera, left_from_world, right_from_world, depth, params, first.pair, first.range);
  const auto fault = static_cast<RectificationFault>(planned.b);
  if (planned.is(StatusCode::rectification_impossible) &&
      (fault == RectificationFault::epipole_near || fault == RectificationFault::too_large)) {
    return plan_polar_rectification(camera, left_from_world, right_from_world, depth, params, plan);
  }
  if (!planned.ok() && !planned.is(StatusCode::disparity_range_exceeded)) return planned;
  plan.method = RectificationMethod::homography;
  plan.count = 1;
  plan.blind_radius_px = 0;
  plan.resolution = first.pair.resolution;
  plan.baseline = first.pair.baseline;
  plan.disparity_per_inverse_depth_px = first.pair.focal_px * first.pair.baseline;
  return planned;
}

}  // namespace ilp
