// Bundle adjustment of one window: cameras with known intrinsics and points, Levenberg-Marquardt on the Schur
// complement (B. Triggs, P. McLauchlan, R. Hartley, A. Fitzgibbon, "Bundle Adjustment - A Modern Synthesis", 2000).
//
// A free camera has six parameters: a rotation vector w, R <- exp([w]x) R, and its centre C; x_cam = R (X - C).
// Observations are ideal pixels (distortion removed), the residual is projection minus observation in px. Points are
// always free.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/bundle/bundle_equations.hpp"

namespace ilp {

/// The adjustment and its scratch of a few megabytes: keep it in static storage. Between `begin` or `resume` and
/// `finish` the problem belongs to the adjuster. After each `step` its poses and points are the best so far.
class BundleAdjuster {
 public:
  /// `invalid_argument` (camera, point, observation, parameters, scale hold, where there are several with the
  /// index) for non-finite values, indices out of range, or two observations of a point in one
  /// camera; `no_model` when no observation can be used.
  Status begin(BundleProblem& problem, const BundleParams& params);
  /// Continues from `progress`, which an earlier `begin` or `step` left together with this problem. The observations
  /// that `begin` dropped must have been removed.
  Status resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress);
  /// Does one iteration: linearise, solve, try. Does nothing once done.
  Status step();
  [[nodiscard]] const BundleProgress& progress() const { return progress_; }
  /// Restores a held distance exactly and computes errors and covariances; the joint covariance only on request.
  Status finish(BundleResult& result, BundleCovariance* joint = nullptr);
  /// Runs begin, step until done, finish.
  Status run(BundleProblem& problem, const BundleParams& params, BundleResult& result,
             BundleCovariance* joint = nullptr);

 private:
  bundle::Equations equations_;
  BundleProgress progress_;
};

}  // namespace ilp
