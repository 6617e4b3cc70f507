// The error that two poses give to the depth between them. Unlike the error of matching it is common to the whole
// image: averaging over pixels does not reduce it.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// Covariance of the step between two cameras: rotation vector in the axes of the second one (rad, its estimated
/// attitude is exp(error) times the true one), then the place of the second in the axes of the first (world units).
/// Lower triangle, row by row; all 0 when it is not known.
struct StepCovariance {
  static constexpr int elements = 21;
  double lower[elements] = {};

  [[nodiscard]] bool known() const { return lower[elements - 1] > 0; }
};

/// The step from camera a over b to c, whose two steps have these covariances. They count as independent; 0 if one of
/// them is not known.
[[nodiscard]] StepCovariance joined_steps(const RigidTransform& b_from_a, const StepCovariance& first,
                                          const RigidTransform& c_from_b, const StepCovariance& second);

/// One sigma of the depth, as a share of it, of ground at `depth` (along the optical axis) in direction `normalised`
/// (X/Z, Y/Z) of the first camera. The match counts as exact, so that an error of the step shifts it along its epipolar
/// line. The error grows without bound towards the epipole. 0 when the covariance is not known, or the second camera is
/// not in front of the ground.
[[nodiscard]] double depth_error_of_poses(const RigidTransform& second_from_first, const StepCovariance& covariance,
                                          const Vec2& normalised, double depth);

inline constexpr std::int32_t pose_error_stride_px = 16;
struct PoseErrorScratch {
  double values[limits::max_image_pixels / pose_error_stride_px / pose_error_stride_px];
};

/// The median of these errors at every 16th pixel of every 16th row with a depth; 0 when there is none, or when the
/// covariance is not known. `inverse_depth` has the size of the first camera.
[[nodiscard]] double median_depth_error_of_poses(const RigidTransform& second_from_first,
                                                 const StepCovariance& covariance, const CameraModel& camera,
                                                 ImageView<const float> inverse_depth, PoseErrorScratch& scratch);

}  // namespace ilp
