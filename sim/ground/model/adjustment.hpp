// Bundle adjustment of all cameras and points of a model, by Ceres. No type of Eigen stands here: flight code compiles
// Eigen with other settings than Ceres does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ilp::model {

struct AdjustedCamera {
  double cam_from_world[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< rotation, row-major
  double centre[3] = {0, 0, 0};
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
};

struct AdjustedPoint {
  double position[3] = {0, 0, 0};
};

struct AdjustedObservation {
  std::uint32_t camera = 0, point = 0;
  double x = 0, y = 0;  ///< ideal px
};

/// What is known of the depth of a point in a camera from elsewhere.
struct AdjustedDepth {
  std::uint32_t camera = 0, point = 0;
  double inverse_depth = 0;
  double sigma = 0.01;  ///< relative
};

struct AdjustmentParams {
  double robust_px = 0.5;  ///< scale of Cauchy's loss
  int max_iterations = 40;
};

/// Minimises the reprojection errors with Cauchy's loss. The first camera stays where it is, and one coordinate of the
/// camera farthest from it, which holds the scale. One thread, so that the same problem has the same result. False,
/// with cameras as they were, where there is nothing to adjust or no step helps.
[[nodiscard]] bool adjust(std::vector<AdjustedCamera>& cameras, std::vector<AdjustedPoint>& points,
                          const std::vector<AdjustedObservation>& observations,
                          const std::vector<AdjustedDepth>& depths, const AdjustmentParams& params);

/// Covariance of rotation vector (in the camera's axes, rad) and centre, lower triangle row by row.
using PoseCovariance = std::array<double, 21>;
inline constexpr std::size_t max_cameras_with_errors = 400;

/// Errors of adjusted cameras, to first order: the inverse of the normal equations without the points (Triggs et al.
/// 2000, 9.4), times the variance of the residuals for each degree of freedom. The first camera and one coordinate of
/// the camera farthest from it are the gauge and have no error. Empty for more than max_cameras_with_errors cameras, or
/// where the observations leave some camera free.
[[nodiscard]] std::vector<PoseCovariance> pose_covariances(const std::vector<AdjustedCamera>& cameras,
                                                           const std::vector<AdjustedPoint>& points,
                                                           const std::vector<AdjustedObservation>& observations,
                                                           const std::vector<AdjustedDepth>& depths);

}  // namespace ilp::model
