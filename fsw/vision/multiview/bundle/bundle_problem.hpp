// Input and output of a bundle adjustment.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/levenberg_marquardt.hpp"

namespace ilp {

struct BundleCamera {
  Pose pose;
  double fx = 0, fy = 0;  ///< px
  double cx = 0, cy = 0;  ///< px
  bool fixed = false;     ///< the observations are used, but the pose does not move and is not written
};

struct BundlePoint {
  double position[3] = {0, 0, 0};  ///< world
};

struct BundleObservation {
  std::uint16_t camera = 0;  ///< index into BundleProblem::cameras
  std::uint16_t point = 0;   ///< index into BundleProblem::points
  double x = 0, y = 0;       ///< ideal px
};

/// Holds the distance between camera `anchor` (free) and camera `origin` (the only fixed one) if nothing else
/// determines the scale.
struct BundleScaleHold {
  bool held = false;
  std::uint16_t origin = 0, anchor = 0;
};

/// Measurement of an attitude sensor. The rotation from the measured to the adjusted attitude, as a rotation vector in
/// the camera's axes, should be zero. A sensor with a less accurate heading has a larger sigma about the axis that
/// looks down.
struct BundleAttitudePrior {
  std::uint16_t camera = 0;
  double q_cam_from_world[4] = {1, 0, 0, 0};  ///< measured attitude, unit quaternion w, x, y, z
  double sigma_rad[3] = {1, 1, 1};            ///< about the camera's axes
};

struct BundleProblem {
  FixedVector<BundleCamera, limits::max_bundle_cameras> cameras;
  FixedVector<BundlePoint, limits::max_bundle_points> points;
  FixedVector<BundleObservation, limits::max_bundle_observations> observations;  ///< in any order
  BundleScaleHold hold;
  /// Used by the calibration; BundleAdjuster ignores them.
  FixedVector<BundleAttitudePrior, limits::max_bundle_cameras> attitudes;
};

struct BundleParams {
  std::uint32_t max_iterations = 20;
  double relative_tolerance = 1e-6;  ///< the adjustment ends when a step reduces the cost by less than this fraction
  double robust_px = 0;              ///< scale of Cauchy's loss; 0 = plain least squares
};

/// The state of an adjustment between iterations, in addition to the problem itself. With it the adjustment can be
/// interrupted, stored and resumed with a bit-identical result.
struct BundleProgress {
  LevenbergMarquardt descent;  ///< its cost in px^2
  double initial_cost = 0;     ///< px^2
  double initial_rms_px = 0;
  double held_distance = 0;
};

struct BundleResult {
  double initial_cost = 0, final_cost = 0;      ///< half the sum of squared residuals, or of their loss if robust, px^2
  double initial_rms_px = 0, final_rms_px = 0;  ///< RMS per residual coordinate, without robust weights
  std::uint32_t iterations = 0;
  bool converged = false;
  std::uint32_t points = 0, observations = 0;  ///< numbers of points and observations that were used
  /// Observations that were not used: behind their camera at the start, or the only one of their point.
  std::uint32_t dropped_observations = 0;
  /// Whether the covariances are valid: true if two cameras are fixed, or if one is fixed and a held distance
  /// determines the scale. They follow from the inverse of the reduced normal equations and the variance of the
  /// residuals (bundle_covariance.hpp), and are relative to the fixed cameras.
  bool covariance_valid = false;
  struct PositionCovariance {
    double sigma[3] = {0, 0, 0};  ///< one sigma, world axes; 0 for fixed cameras
    double matrix[9] = {};
  };
  std::array<PositionCovariance, limits::max_bundle_cameras> cameras{};
};

}  // namespace ilp
