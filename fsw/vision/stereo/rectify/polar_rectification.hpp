// Polar rectification for general motion, with the epipole inside, near or outside the images (M. Pollefeys, R. Koch,
// L. Van Gool, "A simple and efficient rectification method for general motion", ICCV 1999). It works on directions
// instead of pixels: rows are half planes that end in the baseline, so that both images share them with their
// orientation, and columns are the logarithm of tan(half the angle from the baseline). The map is conformal (Mercator's
// about the baseline), so windows keep their shape, and an advance over level ground is a constant shift near the
// epipole.
#pragma once

#include "fsw/vision/stereo/rectify/rectification_plan.hpp"

namespace ilp {

/// Divides the common view into rings about the epipole and rings into sectors, so that each panel fits the limits with
/// polar_scale of the image's resolution at its outer edge, at least min_scale, and more inwards. Errors:
/// `rectification_impossible` (b = RectificationFault; too large: more panels than max_rectified_panels; no parallax:
/// no ground of the range moves by min_parallax_px); `invalid_argument` for an empty depth range.
/// `disparity_range_exceeded` is a warning: the plan is usable, but the near end of a panel's range was cut.
Status plan_polar_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                                const RigidTransform& right_from_world, const DepthRange& depth,
                                const RectificationParams& params, RectificationPlan& plan);

}  // namespace ilp
