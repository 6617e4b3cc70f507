// Normal equations for the intrinsics of a camera, from the images of a window of posed keyframes. The unknowns are
// poses, points, seven intrinsics and the readout time; poses and points are eliminated (B. Triggs et al., "Bundle
// Adjustment - A Modern Synthesis", 2000, section 6).
#pragma once

#include <array>

#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/calibration/measured_places.hpp"
#include "fsw/vision/geometry/rolling_shutter.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"

namespace ilp {

/// The intrinsics in the order of Intrinsic (focal length and principal point in px), and the readout time in s.
inline constexpr std::size_t camera_unknowns = intrinsic_count + 1;
inline constexpr std::size_t readout_unknown = intrinsic_count;
using CameraUnknowns = std::array<double, camera_unknowns>;

/// Standard deviation of each unknown for a camera that was never calibrated. They are the units of the equations.
[[nodiscard]] CameraUnknowns usual_errors(const CameraModel& nominal);
/// The camera with `corrections` added; both focal lengths change by the same factor.
[[nodiscard]] CameraModel corrected(const CameraModel& camera, const CameraUnknowns& corrections);

/// Motion of the images of a window during the readout of a rolling shutter.
struct WindowMotion {
  double readout_s = 0;       ///< readout time with which the images were corrected to the middle row's time
  bool readout_open = false;  ///< the readout time is an unknown
  std::array<ImageMotion, limits::max_calibration_views> of_view{};  ///< of each view; 0: unknown
  std::array<double, limits::max_calibration_views> sigma_px_s{};    ///< standard deviation of the motion along x and y
};

/// Mean residuals of the parts of an image, over many windows.
struct ResidualField {
  static constexpr std::size_t columns = 8, rows = 6;
  struct Cell {
    double weight = 0, x = 0, y = 0;  ///< sums of weights, and of weights times residuals in px
  };
  std::array<Cell, columns * rows> cells{};
  double weight = 0, squared = 0;  ///< sums over all residuals, which have two coordinates each
};

struct IntrinsicsEquations {
  std::uint32_t points = 0, observations = 0;
  double noise_px = 0;  ///< weighted RMS of a residual's coordinate, after the adjustment of poses and points
  /// Normal equations of the camera in units of usual_errors(), divided by the variance of an observation.
  std::array<CameraUnknowns, camera_unknowns> information{};
  CameraUnknowns gradient{};
  double gained = 0;  ///< twice the decrease of the cost by the window's own correction
  /// c^T displacement c is the mean squared displacement of the window's camera centres by a correction c, after
  /// removal of a similarity, divided by their mean squared distance from their middle.
  std::array<CameraUnknowns, camera_unknowns> displacement{};
};

/// Sums over the points below a view, for the distance of the ground along its measured vertical.
struct GroundSums {
  double points = 0, distance = 0, squared = 0;
};

/// Scratch. Nothing in it is kept from call to call.
struct IntrinsicsWorkspace {
  static constexpr std::size_t poses = 6 * (limits::max_calibration_views - 1);
  static constexpr std::size_t rates = 2 * limits::max_calibration_views;  ///< errors of the motion of each view
  static constexpr std::size_t size = poses + rates + camera_unknowns;
  static constexpr std::size_t samples = 4096;
  std::array<double, size * size> system;
  std::array<double, size> right;
  std::array<double, samples> squared;
  std::array<GroundSums, limits::max_calibration_views> ground;                     ///< for the measured heights
  std::array<std::array<double, size>, limits::max_calibration_views> by_unknowns;  ///< sums of its derivatives
};

struct ReductionParams {
  double error_factor = 3;  ///< standard deviation of an observation divided by the scatter of the residuals
  std::uint32_t steps = 2;  ///< adjustment steps of poses and points before the equations are formed
  const MeasuredPlaces* places = nullptr;    ///< of the window's views, as measured by the vehicle; null: none
  const MeasuredHeights* heights = nullptr;  ///< likewise; used only together with places
  const WindowMotion* motion = nullptr;      ///< of the window's images; null: no rolling shutter
};

/// Adjusts poses and points of the window with `camera` unchanged, forms the equations at the result, and adds the
/// residuals that remain after the correction to `field`. Observations are ideal px of `camera`, and all observations
/// of a point are consecutive. Residuals are in px of the real image, with Cauchy weights. The standard deviation of an
/// observation is error_factor times the scatter of the residuals, as for the estimated errors of poses. A direction
/// that the window does not determine has no information.
///
/// The window's attitudes come from a sensor with its own world frame: only the rotation of each view from the first
/// one is used. The places of `params` have another world frame: only the shape of the track is used, not its scale,
/// rotation and position. Heights are compared with the distance to the ground vertically below the view, in the scale
/// of the places. With a `motion`, each row is treated as if it had been corrected to the middle row's time with the
/// camera's readout time, and the error of the motion is another unknown of each view.
///
/// Returns `invalid_argument` if the window or the camera is out of range. `equations.points` is 0 if the window has
/// fewer than three cameras.
Status reduce_to_intrinsics(const CameraModel& camera, const ReductionParams& params, BundleProblem& window,
                            IntrinsicsWorkspace& workspace, IntrinsicsEquations& equations, ResidualField& field);

}  // namespace ilp
