// Joint covariance of all free cameras of a bundle adjustment, and its dependence on the fixed cameras, so that errors
// can be propagated from window to window along a strip.
//
// Parameters of a camera, in this order: rotation vector w in the camera's axes, R <- exp([w]x) R, rad; centre C, world
// units. Let F be the covariance of the m fixed cameras, 6m x 6m and independent of the noise of this window's
// observations. Then the covariance of the free cameras is
//
//   conditional + A F A^T,  A = transfer,
//
// and their cross-covariance with the fixed cameras is A F. Both follow from the normal equations after the points have
// been eliminated, S df + S_fm dm = 0 (Triggs et al., "Bundle Adjustment - A Modern Synthesis", 2000, section 9): the
// conditional covariance is a multiple of S^-1, the transfer is -S^-1 S_fm. Second derivatives are neglected, as in the
// adjustment itself.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"

namespace ilp {

/// The joint covariance. About 100 KB: keep it in static memory.
struct BundleCovariance {
  static constexpr std::size_t camera_size = 6;
  static constexpr std::size_t max_system = camera_size * limits::max_bundle_cameras;
  /// The product of the numbers of free and fixed cameras is at most the square of half their sum.
  static constexpr std::size_t max_transfer = max_system * max_system / 4;

  /// True if the scale is determined, by two fixed cameras or by one fixed camera and a held distance, and there are
  /// more observations than unknowns. If false, all other members are 0.
  bool valid = false;
  std::uint16_t free_count = 0, fixed_count = 0;
  std::array<std::uint16_t, limits::max_bundle_cameras> free_camera{};   ///< indices into BundleProblem::cameras
  std::array<std::uint16_t, limits::max_bundle_cameras> fixed_camera{};  ///< indices into BundleProblem::cameras
  /// Factor between S^-1 and the covariance, px^2: the variance of a residual coordinate, with Huber's correction if
  /// the adjustment was robust. Simulated errors agree within 10 % of sigma. With a loss whose scale is 2.5 times the
  /// noise they agree within 15 %; with a scale as small as the noise they are up to 1.5 times as large.
  double variance = 0;
  /// Covariance of the n free cameras if the fixed cameras are without error: 6n x 6n, row-major without gaps. A held
  /// distance also counts as exact, so there is no variance along the line between its two cameras.
  std::array<double, max_system * max_system> conditional{};
  /// Derivative of the free cameras' optimum with respect to the poses of the m fixed cameras: 6n x 6m, row-major
  /// without gaps. A held distance stays constant, so the window follows its one fixed camera as a rigid body.
  std::array<double, max_transfer> transfer{};
  /// Derivative of the free cameras' optimum with respect to the logarithm of the held distance, 6n elements; 0 if no
  /// distance is held. A held distance with relative variance v adds v s s^T to the covariance.
  std::array<double, max_system> scale{};
};

}  // namespace ilp
