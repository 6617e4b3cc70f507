// Propagates the errors of a strip's cameras from window to window.
//
// Gauge: the world frame of the strip. The pose of the first camera and the length of the first baseline define it, so
// they are without error. The error of any other camera is the error of its pose in this world. It grows with the
// distance from the first camera, because the first camera's attitude and the scale of the first baseline are only as
// good as the matches of the first images. For a comparison with the truth, align the truth with the strip at the first
// camera and its baseline.
//
// A window has free cameras f, fixed cameras m, and perhaps a held distance L between two cameras. It gives
// (bundle_covariance.hpp) the conditional covariance C, the transfer A and the scale s. With the covariance P before
// the window,
//
//   df = A dm + s d(log L) + noise = G dx + noise,   P_ff = C + G P G^T,   P_fo = G P_o
//
// where x are all kept cameras before the window and o those that the window does not move. This assumes that the noise
// of a window's observations is independent of the errors of the cameras before it, although some observations were
// used to estimate these. On simulated matches the assumption does no harm.
//
// C does not follow from the normal equations alone. Each keyframe is matched to patches of the previous keyframe, so
// errors add up along a track, and the observations of a track are not independent. Different tracks are independent.
// Hence C is the covariance that is robust to correlation within tracks, C = c S^-1 (sum g g^T) S^-1: g is the gradient
// of one track with respect to the free cameras, S^-1 the inverse of the normal equations, c the correction for a small
// number of tracks (H. White, "Maximum likelihood estimation of misspecified models", Econometrica 1982; clusters:
// K.-Y. Liang, S. Zeger, Biometrika 1986).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_covariance.hpp"

namespace ilp {

struct BundleParams;   // bundle_adjustment.hpp
struct BundleProblem;  // bundle_adjustment.hpp
struct WindowMap;      // window_problem.hpp

/// Joint covariance of the kept cameras. The block of SequenceState::cameras[i] begins at row and column 6 i: rotation
/// vector in the camera's axes (rad), then centre (world units). Zero for the first camera of the strip.
struct StripCovariance {
  static constexpr std::size_t camera_size = BundleCovariance::camera_size;
  static constexpr std::size_t size = BundleCovariance::max_system;
  std::array<double, size * size> matrix{};  ///< row-major, symmetric
  std::uint32_t known = 0;                   ///< bit i: the errors of camera i are known
  /// Derivative of the poses with respect to the seven intrinsics (Intrinsic): how the strip would change if it were
  /// built with other intrinsics. Row-major, `intrinsic_count` columns.
  std::array<double, size * intrinsic_count> by_intrinsics{};

  [[nodiscard]] double variance_of_centre(std::size_t camera, std::size_t axis) const {
    return matrix[(camera_size * camera + 3 + axis) * (size + 1)];
  }
};

struct StripCovarianceWorkspace {
  BundleCovariance window;
  std::array<double, StripCovariance::size * StripCovariance::size> scatter;
  /// Derivative of the window's free parameters with respect to all kept cameras as they were before the window.
  std::array<double, StripCovariance::size * StripCovariance::size> derivative;
  std::array<double, StripCovariance::size * StripCovariance::size> product;
  /// Derivative of the window's free parameters with respect to the intrinsics, with the fixed cameras unchanged.
  std::array<double, StripCovariance::size * intrinsic_count> by_intrinsics;
};

/// Covariance of the intrinsics, in the order of Intrinsic; 0 for a camera that is known.
using IntrinsicsCovariance =
    Eigen::Matrix<double, static_cast<int>(intrinsic_count), static_cast<int>(intrinsic_count)>;
[[nodiscard]] IntrinsicsCovariance intrinsics_covariance(
    const std::array<double, intrinsic_count*(intrinsic_count + 1) / 2>& lower);
/// Adds the effect of the intrinsics' errors to the covariance of a camera: lower triangle `pose` += J C J^T, where J
/// is the derivative of the camera with respect to the intrinsics and C is `lens`.
void add_error_of_lens(const StripCovariance& strip, std::size_t index, const IntrinsicsCovariance& lens,
                       double (&pose)[21]);
/// The two cameras of a step: camera `index` of the strip and the one before it.
struct StripStep {
  std::size_t index;
  RigidTransform previous, camera;
};
/// Returns the relative one-sigma error that the intrinsics cause in depths near `depth` (along the optical axis of the
/// previous camera, world units) from a match of the step, through its rays and both poses. It is the RMS over the
/// image; 0 if it is not known or the cameras have no common ground.
[[nodiscard]] double depth_error_of_lens(const StripCovariance& strip, const StripStep& step, const CameraModel& model,
                                         const IntrinsicsCovariance& lens, double depth);

/// Copies the covariance of camera `index`, lower triangle row by row. All 0 if it is not known.
void covariance_of_camera(const StripCovariance& strip, std::size_t index, double (&lower)[21]);

/// Computes the covariance of the step from camera `index` - 1 to camera `index`, whose poses are `previous` and
/// `camera`, as StepCovariance of fsw/vision/stereo/depth/pose_error.hpp. All 0 if it is not known.
void covariance_of_step(const StripCovariance& strip, std::size_t index, const RigidTransform& previous,
                        const RigidTransform& camera, double (&lower)[21]);

/// Begins a strip: its first camera is camera 0, without error.
void begin_covariance(StripCovariance& strip);
/// Removes camera 0: camera i + 1 becomes camera i.
void drop_oldest_camera(StripCovariance& strip);
/// Computes the window's derivative with respect to the intrinsics of `camera`; the observations of `problem` are ideal
/// pixels of this camera. Call it before allow_correlated_tracks().
void derive_by_intrinsics(const BundleProblem& problem, const BundleParams& params, const CameraModel& camera,
                          StripCovarianceWorkspace& workspace);
/// Replaces window.conditional of a finished adjustment by the covariance for correlated tracks. It stays unchanged if
/// there are too few tracks. `params` are those of the adjustment. The observations of a point must be consecutive, as
/// build_window writes them.
void allow_correlated_tracks(const BundleProblem& problem, const BundleParams& params,
                             StripCovarianceWorkspace& workspace);
/// Updates the errors of the free cameras from `workspace.window`. If the window has no covariance, or a fixed camera
/// is unknown, known cameras keep their errors.
void propagate_covariance(const BundleProblem& problem, const WindowMap& map, StripCovarianceWorkspace& workspace,
                          StripCovariance& strip);

}  // namespace ilp
