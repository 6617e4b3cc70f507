// Bundle adjustment of one window of cameras with known intrinsics, and of their points, by Levenberg-Marquardt on the
// Schur complement (B. Triggs, P. McLauchlan, R. Hartley, A. Fitzgibbon, "Bundle Adjustment - A Modern Synthesis",
// 2000).
//
// A free camera has six parameters: a rotation vector w, R <- exp([w]x) R, and its centre C; x_cam = R (X - C).
// Observations are ideal pixels (distortion removed). A residual is projection minus observation, px. Points are always
// free.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/bundle/bundle_equations.hpp"

namespace ilp {

/// The adjustment and its scratch memory, a few megabytes: keep it in static memory. The caller must not change the
/// problem between `begin` or `resume` and `finish`. After each `step` its poses and points are the best so far.
class BundleAdjuster {
 public:
  /// Begins an adjustment. Returns `invalid_argument` if a value is not finite, an index is out of range, or a point
  /// has two observations by one camera; the status says which: camera, point, observation, parameters or scale hold,
  /// and its index. Returns `no_model` if no observation can be used.
  Status begin(BundleProblem& problem, const BundleParams& params);
  /// Continues from `progress`, which an earlier `begin` or `step` left together with this problem. The observations
  /// that `begin` dropped must have been removed.
  Status resume(BundleProblem& problem, const BundleParams& params, const BundleProgress& progress);
  /// Does one iteration: linearises, solves, and tries the step. Does nothing when the adjustment is done.
  Status step();
  [[nodiscard]] const BundleProgress& progress() const { return progress_; }
  /// If the problem holds a distance, restores it exactly. Computes errors and covariances. The joint covariance is
  /// computed only if `joint` is given.
  Status finish(BundleResult& result, BundleCovariance* joint = nullptr);
  /// Runs begin, then step until it is done, then finish.
  Status run(BundleProblem& problem, const BundleParams& params, BundleResult& result,
             BundleCovariance* joint = nullptr);

 private:
  bundle::Equations equations_;
  BundleProgress progress_;
};

}  // namespace ilp
