// Bundle adjustment of all cameras and points of a model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::model {

struct AdjustedCamera {
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
};

struct AdjustedObservation {
  std::uint32_t camera = 0, point = 0;
  double x = 0, y = 0;  ///< ideal px
};

/// What is known of the depth of a point in a camera that observes it from elsewhere.
struct AdjustedDepth {
  std::uint32_t camera = 0, point = 0;
  double inverse_depth = 0;
  double sigma = 0.01;  ///< relative
};

/// What is known of a camera's pose by itself, as by a fix on a map.
struct AdjustedPrior {
  std::uint32_t camera = 0;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  /// Brings the camera's turn from there, a rotation vector in its axes, and its way from there to residuals in pixels.
  Eigen::Matrix<double, 6, 6> px_from_error = Eigen::Matrix<double, 6, 6>::Zero();
  double robust_px = 0;  ///< scale of Cauchy's loss of all six residuals together; 0: squares
};

struct AdjustmentProblem {
  std::vector<AdjustedCamera> cameras;
  std::vector<Vec3> points;
  std::vector<AdjustedObservation> observations;  ///< in the order of their points, one for a camera and a point
  std::vector<AdjustedDepth> depths;              ///< likewise
  std::vector<AdjustedPrior> priors = {};         ///< with any, the problem stands where they put it
};

struct AdjustmentParams {
  double robust_px = 0.5;  ///< scale of Cauchy's loss
  std::uint32_t max_iterations = 40;
  double tolerance = 1e-6;  ///< the last step lessens the cost by less than this share of it
};

struct Adjusted {
  bool moved = false;  ///< otherwise there was nothing to adjust or no step helped, and the problem is as it was
  std::uint32_t iterations = 0;  ///< in which the equations were solved
  double cost = 0;  ///< half the sum of the losses, those of priors too, and of the squared residuals of the depths
};

/// Minimises the reprojection errors with Cauchy's loss, by Levenberg's and Marquardt's method. Without priors the
/// first camera stays where it is, and one coordinate of the camera farthest from it, which holds the scale. The same
/// problem has the same result, bit by bit.
Adjusted adjust(AdjustmentProblem& problem, const AdjustmentParams& params);

/// What has no error, and what an adjustment without priors leaves where it is: the first camera that observes
/// anything, and the largest component of the distance to the camera farthest from it.
struct Gauge {
  std::uint32_t first = 0, anchor = 0;
  int component = 0;
};
[[nodiscard]] Gauge gauge_of(const AdjustmentProblem& problem);

}  // namespace ilp::model
