// Polar rectification for general motion, with the epipole inside, near or outside the images (M. Pollefeys, R. Koch,
// L. Van Gool, "A simple and efficient rectification method for general motion", ICCV 1999). It works on directions
// instead of pixels. Rows are half planes bounded by the baseline, so that both images share them and their
// orientation. Columns are the logarithm of tan(angle from the baseline / 2). The map is conformal (Mercator's
// projection about the baseline), so windows keep their shape, and near the epipole an advance over level ground is a
// shift by a constant number of columns.
#pragma once

#include "fsw/vision/stereo/rectify/rectification_plan.hpp"

namespace ilp {

/// Divides the common view into rings about the epipole, and rings into sectors, so that each panel fits the limits. At
/// its outer edge a ring has polar_scale of the image's resolution (at least min_scale), and more towards the epipole.
/// Returns `rectification_impossible` (b = RectificationFault) if no plan exists: `too_large` if it needs more panels
/// than max_rectified_panels, `no_parallax` if no ground in the depth range moves by min_parallax_px. Returns
/// `invalid_argument` if the depth range is empty. `disparity_range_exceeded` is a warning: the plan is usable, but the
/// near end of a panel's range was cut.
Status plan_polar_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                                const RigidTransform& right_from_world, const DepthRange& depth,
                                const RectificationParams& params, RectificationPlan& plan);

}  // namespace ilp
