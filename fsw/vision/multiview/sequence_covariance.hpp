// Errors of a strip's cameras, carried from window to window.
//
// Gauge: the strip's world itself. The first camera's pose and the length of the first baseline define it, so they are
// without error. The error of every other camera is that of its pose in this world. It grows with the distance from the
// first one, because the attitude of the first camera and the scale of the first baseline are only as good as the
// matches of the first images. For a comparison, align the truth with the strip at the first camera and its baseline.
//
// A window has free cameras f, fixed ones m, perhaps a held distance L between two cameras, and gives
// (bundle_covariance.hpp) the conditional covariance C, the transfer A and the scale s. With P the covariance before
// it,
//
//   df = A dm + s d(log L) + noise = G dx + noise,   P_ff = C + G P G^T,   P_fo = G P_o
//
// where x are all kept cameras before the window and o those that it does not move. This assumes that the noise of a
// window's observations is independent of the errors of the cameras before it, although some observations were used to
// estimate these. On simulated matches the assumption does no harm.
//
// C does not come from the normal equations alone. Each keyframe is matched to patches of the previous keyframe, so
// that errors add up along a track and its observations are not independent. Different tracks are, hence the covariance
// that is robust to correlation within them: C = c S^-1 (sum g g^T) S^-1, g the gradient of one track by the free
// cameras, S^-1 the inverse normal equations, c the correction for few tracks (H. White, "Maximum likelihood estimation
// of misspecified models", Econometrica 1982; clusters: K.-Y. Liang, S. Zeger, Biometrika 1986).
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

/// Joint covariance of the kept cameras. SequenceState::cameras[i] begins at 6 i: rotation vector in the camera's axes
/// (rad), then centre (world units). Zero for the first camera of the strip.
struct StripCovariance {
  static constexpr std::size_t camera_size = BundleCovariance::camera_size;
  static constexpr std::size_t size = BundleCovariance::max_system;
  std::array<double, size * size> matrix{};  ///< row-major, symmetric
  std::uint32_t known = 0;                   ///< bit i: the errors of camera i are known
  /// Derivative of the poses by the seven intrinsics (Intrinsic), as the strip is built with another lens.
  std::array<double, size * intrinsic_count> by_intrinsics{};

  [[nodiscard]] double variance_of_centre(std::size_t camera, std::size_t axis) const {
    return matrix[(camera_size * camera + 3 + axis) * (size + 1)];
  }
};

struct StripCovarianceWorkspace {
  BundleCovariance window;
  std::array<double, StripCovariance::size * StripCovariance::size> scatter;
  /// Derivative of the window's free parameters by all kept cameras as they were before it.
  std::array<double, StripCovariance::size * StripCovariance::size> derivative;
  std::array<double, StripCovariance::size * StripCovariance::size> product;
  /// Derivative of the window's free parameters by the intrinsics, with the fixed cameras as they are.
  std::array<double, StripCovariance::size * intrinsic_count> by_intrinsics;
};

/// Covariance of the intrinsics, in the order of Intrinsic; 0 for a camera that is known.
using IntrinsicsCovariance =
    Eigen::Matrix<double, static_cast<int>(intrinsic_count), static_cast<int>(intrinsic_count)>;
[[nodiscard]] IntrinsicsCovariance intrinsics_covariance(
    const std::array<double, intrinsic_count*(intrinsic_count + 1) / 2>& lower);
/// Lower triangle `pose` += J C J^T, J the derivative of this camera by the intrinsics.
void add_error_of_lens(const StripCovariance& strip, std::size_t index, const IntrinsicsCovariance& lens,
                       double (&pose)[21]);
/// The two cameras of a step: the one before camera `index` of the strip, and this one.
struct StripStep {
  std::size_t index;
  RigidTransform previous, camera;
};
/// One sigma, as a share of it, that the lens gives to depth near `depth` (along the optical axis of the camera before)
/// by a match of the step: by its rays and by both poses. Root mean square over the image; 0 if it is not known, or the
/// cameras have nothing in common.
[[nodiscard]] double depth_error_of_lens(const StripCovariance& strip, const StripStep& step, const CameraModel& model,
                                         const IntrinsicsCovariance& lens, double depth);

/// Covariance of camera `index`, lower triangle. All 0 if it is not known.
void covariance_of_camera(const StripCovariance& strip, std::size_t index, double (&lower)[21]);

/// Covariance of the step from camera `index` - 1 to camera `index`, whose poses these are: StepCovariance of
/// fsw/vision/stereo/depth/pose_error.hpp, lower triangle. All 0 if it is not known.
void covariance_of_step(const StripCovariance& strip, std::size_t index, const RigidTransform& previous,
                        const RigidTransform& camera, double (&lower)[21]);

/// Begins with the strip's first camera as camera 0, without error.
void begin_covariance(StripCovariance& strip);
/// Camera i + 1 becomes camera i.
void drop_oldest_camera(StripCovariance& strip);
/// The window's derivative by the intrinsics of `camera`, whose ideal pixels it has. Call it before
/// allow_correlated_tracks().
void derive_by_intrinsics(const BundleProblem& problem, const BundleParams& params, const CameraModel& camera,
                          StripCovarianceWorkspace& workspace);
/// Replaces window.conditional of a finished adjustment by the covariance for correlated tracks; leaves it unchanged if
/// there are too few tracks. `params` are those of the adjustment. The observations of a point are consecutive, as
/// build_window leaves them.
void allow_correlated_tracks(const BundleProblem& problem, const BundleParams& params,
                             StripCovarianceWorkspace& workspace);
/// Updates the errors of the free cameras by `workspace.window`. If the window has no covariance, or a fixed camera is
/// unknown, known cameras keep theirs.
void propagate_covariance(const BundleProblem& problem, const WindowMap& map, StripCovarianceWorkspace& workspace,
                          StripCovariance& strip);

}  // namespace ilp
