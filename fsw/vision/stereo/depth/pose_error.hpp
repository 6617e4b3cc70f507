// Error of depths that comes from the errors of the two camera poses. Unlike the matching error, it is common to the
// whole image: averaging over pixels does not reduce it.
#pragma once

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

/// Covariance of the step between two cameras. Components, in this order: rotation vector in the axes of the second
/// camera (rad; its estimated attitude is exp(error) times the true one), then position of the second camera in the
/// axes of the first (world units). Lower triangle, row by row; all 0 if the covariance is not known.
struct StepCovariance {
  static constexpr int elements = 21;
  double lower[elements] = {};

  [[nodiscard]] bool known() const { return lower[elements - 1] > 0; }
};

/// Returns the covariance of the step from camera a to camera c from those of the steps a to b and b to c, which count
/// as independent. Returns 0 if one of them is not known.
[[nodiscard]] StepCovariance joined_steps(const RigidTransform& b_from_a, const StepCovariance& first,
                                          const RigidTransform& c_from_b, const StepCovariance& second);

/// Returns the relative one-sigma error of the depth of a ground point that the pose errors cause. The point is at
/// `depth` (along the optical axis, world units) in direction `normalised` (X/Z, Y/Z) of the first camera. The match
/// counts as exact, so that an error of the step shifts it along its epipolar line. The error grows without bound
/// towards the epipole. Returns 0 if the covariance is not known or the point is not in front of the second camera.
[[nodiscard]] double depth_error_of_poses(const RigidTransform& second_from_first, const StepCovariance& covariance,
                                          const Vec2& normalised, double depth);

inline constexpr std::int32_t pose_error_stride_px = 16;
struct PoseErrorScratch {
  double values[limits::max_image_pixels / pose_error_stride_px / pose_error_stride_px];
};

/// Returns the median of depth_error_of_poses over the pixels with depth of a grid with a spacing of
/// pose_error_stride_px; 0 if there are none or the covariance is not known. `inverse_depth` has the image size of the
/// first camera.
[[nodiscard]] double median_depth_error_of_poses(const RigidTransform& second_from_first,
                                                 const StepCovariance& covariance, const CameraModel& camera,
                                                 ImageView<const float> inverse_depth, PoseErrorScratch& scratch);

}  // namespace ilp
