// The normal equations of an adjustment where a model stands, without its points (B. Triggs et al., "Bundle Adjustment
// - A Modern Synthesis", 2000, 6.1).
#pragma once

#include <optional>
#include <vector>

#include "sim/ground/model/adjustment.hpp"
#include "sim/ground/model/camera_system.hpp"

namespace ilp::model {

/// How observations and depths count.
struct ResidualWeights {
  double robust_px = 0;  ///< scale of Cauchy's loss; 0: squares
  double depth = 1;      ///< factor of the squares of depths
};

/// Moves of cameras, rotation vector in their axes and centre, and of points.
struct AdjustmentStep {
  std::vector<Vec6> cameras;
  std::vector<Vec3> points;
  double expected = 0;  ///< by how much the cost falls if it is quadratic
};

/// The equations of the cameras, without the points: what an adjustment knows of its cameras.
struct CameraEquations {
  std::vector<CameraBlock> blocks;
  std::vector<Vec6> right;  ///< by camera
};

/// Half the sum of the losses, without those of priors; infinite where a point lies behind a camera that observes it.
[[nodiscard]] double cost_of_points(const AdjustmentProblem& problem, const ResidualWeights& weights);
/// With those of priors.
[[nodiscard]] double cost_of(const AdjustmentProblem& problem, const ResidualWeights& weights);
/// By how much a prior is missed: the norm of its residuals, px.
[[nodiscard]] double error_of(const AdjustmentProblem& problem, const AdjustedPrior& prior);

class NormalEquations {
 public:
  /// Of problems with these cameras, points, observations and depths, wherever they stand.
  explicit NormalEquations(const AdjustmentProblem& problem);

  /// `damping`: what is added to the diagonal, as a share of it. None where some unknown is not determined.
  [[nodiscard]] std::optional<AdjustmentStep> step(const AdjustmentProblem& problem, const ResidualWeights& weights,
                                                   double damping);
  /// By camera, the covariance of its rotation vector and centre where residuals have an error of 1. Empty where some
  /// camera is not determined.
  [[nodiscard]] std::vector<Mat6> covariances(const AdjustmentProblem& problem, const ResidualWeights& weights);
  /// Nothing is held: no camera is the gauge. None where some point is not determined.
  [[nodiscard]] std::optional<CameraEquations> of_cameras(const AdjustmentProblem& problem,
                                                          const ResidualWeights& weights);

 private:
  struct PointPart;
  /// Calls `take(camera, residual, weight)` for all that is known of a point.
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

  std::vector<std::size_t> first_observation_, first_depth_;  ///< by point, and the end
  std::vector<std::uint8_t> observing_;                       ///< by camera
  std::optional<Gauge> gauge_;                                ///< none where there are priors
  CameraSystem system_;
  std::vector<Mat6> normal_;        ///< by camera, with the points where they are
  std::vector<Vec6> right_, down_;  ///< without the points; with them where they are
};

}  // namespace ilp::model
