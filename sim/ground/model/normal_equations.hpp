// The normal equations of a bundle adjustment, reduced to the cameras by eliminating the points (B. Triggs et al.,
// "Bundle Adjustment - A Modern Synthesis", 2000, 6.1).
#pragma once

#include <optional>
#include <vector>

#include "sim/ground/model/adjustment.hpp"
#include "sim/ground/model/camera_system.hpp"

namespace ilp::model {

/// Weights of observations and depths.
struct ResidualWeights {
  double robust_px = 0;  ///< scale of Cauchy's loss of observations; 0: least squares
  double depth = 1;      ///< weight of a squared normalised depth residual, px^2
};

/// Increments of all unknowns.
struct AdjustmentStep {
  std::vector<Vec6> cameras;  ///< rotation vector in the camera's axes (rad), and centre
  std::vector<Vec3> points;
  double expected = 0;  ///< decrease of the cost if it is quadratic
};

/// The reduced equations of the cameras.
struct CameraEquations {
  std::vector<CameraBlock> blocks;
  std::vector<Vec6> right;  ///< right side of each camera
};

/// Half the sum of the losses without priors; infinite if a point lies behind a camera that observes it.
[[nodiscard]] double cost_of_points(const AdjustmentProblem& problem, const ResidualWeights& weights);
/// The same with the losses of priors.
[[nodiscard]] double cost_of(const AdjustmentProblem& problem, const ResidualWeights& weights);
/// Norm of a prior's six residuals, px.
[[nodiscard]] double error_of(const AdjustmentProblem& problem, const AdjustedPrior& prior);

class NormalEquations {
 public:
  /// Analyses the structure. Later calls may pass problems with other values of cameras and points, but with the same
  /// observations, depths and priors.
  explicit NormalEquations(const AdjustmentProblem& problem);

  /// Solves for one step. `damping`: share of the diagonal that is added to it. None if some unknown is not determined.
  [[nodiscard]] std::optional<AdjustmentStep> step(const AdjustmentProblem& problem, const ResidualWeights& weights,
                                                   double damping);
  /// For each camera, the covariance of its rotation vector and centre, for residuals with a standard deviation of 1.
  /// Empty if some camera is not determined.
  [[nodiscard]] std::vector<Mat6> covariances(const AdjustmentProblem& problem, const ResidualWeights& weights);
  /// The reduced equations without a gauge: no unknown is held. None if some point is not determined.
  [[nodiscard]] std::optional<CameraEquations> of_cameras(const AdjustmentProblem& problem,
                                                          const ResidualWeights& weights);

 private:
  struct PointPart;
  /// Calls `take(camera, residual, weight)` for each observation and depth of a point.
  template <typename Take>
  void for_each(const AdjustmentProblem& problem, std::size_t point, const ResidualWeights& weights, Take take) const;
  [[nodiscard]] bool reduce(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping);
  [[nodiscard]] bool accumulate(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping);
  [[nodiscard]] bool accumulate_points(const AdjustmentProblem& problem, const ResidualWeights& weights,
                                       double damping);
  void accumulate_priors(const AdjustmentProblem& problem);
  void eliminate(const PointPart& part, const Mat3& inverse);
  void damp_and_hold(double damping);
  void move_points(const AdjustmentProblem& problem, const ResidualWeights& weights, double damping,
                   AdjustmentStep& step) const;

  std::vector<std::size_t> first_observation_, first_depth_;  ///< index of each point's first one; and the end
  std::vector<std::uint8_t> observing_;                       ///< for each camera: not 0 if it has observations
  std::optional<Gauge> gauge_;                                ///< none if there are priors
  CameraSystem system_;
  std::vector<Mat6> normal_;        ///< diagonal block of each camera before points are eliminated
  std::vector<Vec6> right_, down_;  ///< right sides after points are eliminated, and before
};

}  // namespace ilp::model
