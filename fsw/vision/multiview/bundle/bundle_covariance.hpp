// Joint covariance of all free cameras of a bundle adjustment, and its dependence on the fixed ones, so that errors can
// be propagated from window to window along a strip.
//
// Parameters of a camera, in this order: rotation vector w in the camera's axes, R <- exp([w]x) R, in rad; centre C in
// world units. If the fixed cameras have the covariance F (6m x 6m, free of the noise of this window's observations),
// that of the free ones is
//
//   conditional + A F A^T,  A = transfer,  and their cross-covariance with the fixed ones is A F.
//
// Both follow from the normal equations after the points have been eliminated, S df + S_fm dm = 0 (Triggs et al.,
// "Bundle Adjustment - A Modern Synthesis", 2000, section 9): the conditional covariance is a multiple of S^-1, the
// transfer is -S^-1 S_fm. Second derivatives are left out, as in the adjustment itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

/// About 100 KB: keep it in static storage.
struct BundleCovariance {
  static constexpr std::size_t camera_size = 6;
  static constexpr std::size_t max_system = camera_size * limits::max_bundle_cameras;
  /// Free times fixed cameras are at most the square of half of all.
  static constexpr std::size_t max_transfer = max_system * max_system / 4;

  /// True only if two cameras are fixed, or if one is fixed and a held distance determines the scale, and there are
  /// more observations than unknowns. All other members are 0 if it is false.
  bool valid = false;
  std::uint16_t free_count = 0, fixed_count = 0;
  std::array<std::uint16_t, limits::max_bundle_cameras> free_camera{};   ///< indices into BundleProblem::cameras
  std::array<std::uint16_t, limits::max_bundle_cameras> fixed_camera{};  ///< same
  /// The factor between S^-1 and the covariance, px^2: the variance of a residual coordinate, with
  /// Huber's correction if the adjustment was robust. Simulated errors agree within 10 % of sigma, with a loss whose
  /// scale is 2.5 times the noise within 15 %; with a scale as small as the noise they are up to 1.5 times as large.
  double variance = 0;
  /// 6n x 6n, row-major without gaps, for n free cameras, as if the fixed cameras were without error. A held distance
  /// also counts as exact: there is no variance along the line between its two cameras.
  std::array<double, max_system * max_system> conditional{};
  /// 6n x 6m, row-major without gaps, for m fixed cameras: derivative of the free cameras' optimum by the fixed
  /// cameras' poses. A held distance stays constant, so that the window follows its one fixed camera as a rigid body.
  std::array<double, max_transfer> transfer{};
  /// 6n: derivative of the free cameras' optimum by the logarithm of the held distance; 0 where none is held. A held
  /// distance with relative variance v adds v s s^T to the covariance.
  std::array<double, max_system> scale{};
};

}  // namespace ilp
