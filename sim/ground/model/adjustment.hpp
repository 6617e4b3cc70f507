// Bundle adjustment of all cameras and points of a model.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/vision/geometry/types.hpp"

namespace ilp::model {

// Cameras and points are in one world; its unit is arbitrary.

struct AdjustedCamera {
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< px
};

struct AdjustedObservation {
  std::uint32_t camera = 0, point = 0;
  double x = 0, y = 0;  ///< ideal px (without distortion)
};

/// A measured depth of a point in a camera that observes the point.
struct AdjustedDepth {
  std::uint32_t camera = 0, point = 0;
  double inverse_depth = 0;
  double sigma = 0.01;  ///< standard deviation, relative
};

/// A prior for the pose of one camera, such as a fix on a map.
struct AdjustedPrior {
  std::uint32_t camera = 0;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
  /// Six residuals in pixels = px_from_error * (rotation vector in the camera's axes, offset of the centre), both from
  /// the prior's pose to the camera's.
  Eigen::Matrix<double, 6, 6> px_from_error = Eigen::Matrix<double, 6, 6>::Zero();
  double robust_px = 0;  ///< scale of Cauchy's loss of the norm of the six residuals; 0: least squares
};

struct AdjustmentProblem {
  std::vector<AdjustedCamera> cameras;
  std::vector<Vec3> points;
  std::vector<AdjustedObservation> observations;  ///< sorted by point; at most one per camera and point
  std::vector<AdjustedDepth> depths;              ///< sorted by point
  std::vector<AdjustedPrior> priors = {};         ///< not empty: they determine the gauge
};

struct AdjustmentParams {
  double robust_px = 0.5;  ///< scale of Cauchy's loss of reprojection errors
  std::uint32_t max_iterations = 40;
  double tolerance = 1e-6;  ///< ends after a step that reduces the cost by less than this share of the cost
};

struct Adjusted {
  bool moved = false;            ///< false: nothing to adjust, or no step reduced the cost; the problem has not changed
  std::uint32_t iterations = 0;  ///< number of times that the equations were solved
  double cost = 0;  ///< half the sum of the losses of observations and priors and of the squared depth residuals
};

/// Moves cameras and points to minimise the reprojection errors with Cauchy's loss, by the method of Levenberg and
/// Marquardt. Without priors, gauge_of() says which unknowns are held. Equal problems have bitwise equal results.
Adjusted adjust(AdjustmentProblem& problem, const AdjustmentParams& params);

/// The unknowns that an adjustment without priors holds, so that they have no error: the pose of the camera `first`,
/// and the coordinate `component` of the centre of the camera `anchor`, which holds the scale. `first` is the first
/// camera with an observation; `anchor` and `component` have the largest coordinate difference to it.
struct Gauge {
  std::uint32_t first = 0, anchor = 0;
  int component = 0;  ///< 0 to 2
};
[[nodiscard]] Gauge gauge_of(const AdjustmentProblem& problem);

}  // namespace ilp::model
