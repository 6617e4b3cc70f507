// What the images of posed keyframes ask of the intrinsics of their camera: the normal equations of a window in its
// poses, points, the seven intrinsics and the readout time, reduced to the last two (B. Triggs et al., "Bundle
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

/// One sigma of each, of a camera that nobody has calibrated: the unit of the equations.
[[nodiscard]] CameraUnknowns usual_errors(const CameraModel& nominal);
/// The camera with these corrections; both focal lengths change in proportion.
[[nodiscard]] CameraModel corrected(const CameraModel& camera, const CameraUnknowns& corrections);

/// How the images of a window moved while a rolling shutter read them.
struct WindowMotion {
  double readout_s = 0;       ///< with which the rows were brought to the time of the middle one
  bool readout_open = false;  ///< it is an unknown
  std::array<ImageMotion, limits::max_calibration_views> of_view{};  ///< 0 where it is not known
  std::array<double, limits::max_calibration_views> sigma_px_s{};    ///< one sigma of the motion along x and y
};

/// Mean residuals of the parts of an image, over many windows.
struct ResidualField {
  static constexpr std::size_t columns = 8, rows = 6;
  struct Cell {
    double weight = 0, x = 0, y = 0;  ///< sums of weights, and of weights times residuals in px
  };
  std::array<Cell, columns * rows> cells{};
  double weight = 0, squared = 0;  ///< of all residuals, which have two coordinates each
};

struct IntrinsicsEquations {
  std::uint32_t points = 0, observations = 0;
  double noise_px = 0;  ///< weighted root mean square of a residual's coordinate, with poses and points at their best
  /// Of the camera in units of usual_errors, divided by the variance of an observation.
  std::array<CameraUnknowns, camera_unknowns> information{};
  CameraUnknowns gradient{};
  double gained = 0;  ///< twice what the correction takes off the cost
  /// c^T displacement c: mean square by which a correction c moves the window's camera centres, apart from a
  /// similarity, over their mean square distance from their middle.
  std::array<CameraUnknowns, camera_unknowns> displacement{};
};

/// The distance of the ground below a view, along its measured vertical: sums over the points near it.
struct GroundSums {
  double points = 0, distance = 0, squared = 0;
};

/// Scratch; it carries nothing from call to call.
struct IntrinsicsWorkspace {
  static constexpr std::size_t poses = 6 * (limits::max_calibration_views - 1);
  static constexpr std::size_t rates = 2 * limits::max_calibration_views;  ///< errors of the motion of each view
  static constexpr std::size_t size = poses + rates + camera_unknowns;
  static constexpr std::size_t samples = 4096;
  std::array<double, size * size> system;
  std::array<double, size> right;
  std::array<double, samples> squared;
  std::array<GroundSums, limits::max_calibration_views> ground;                     ///< of the measured heights
  std::array<std::array<double, size>, limits::max_calibration_views> by_unknowns;  ///< sums of its derivatives
};

struct ReductionParams {
  double error_factor = 3;                   ///< of an observation's scatter
  std::uint32_t steps = 2;                   ///< of poses and points before the equations are taken
  const MeasuredPlaces* places = nullptr;    ///< of the window's views, where the vehicle measured them
  const MeasuredHeights* heights = nullptr;  ///< likewise; they count beside places
  const WindowMotion* motion = nullptr;      ///< of the window's images, if a rolling shutter read them
};

/// Adjusts poses and points of the window with the camera as it is, and takes the equations there. Its observations are
/// ideal px of `camera`, all those of a point one after the other; residuals are in px of the real image, with Cauchy
/// weights. An observation counts with error_factor times the scatter of the residuals, as in the estimated errors of
/// poses. A direction that the window does not determine has no information and adds nothing. The residuals that the
/// step leaves are added to `field`. The window's attitudes are those of a sensor in a world of its own: each view's
/// turn from the first one counts. The places of `params` are in another world, too: only the shape of the track
/// counts, not its scale, turn and place. Heights above the ground count against its distance straight below the view,
/// in the scale of the places. With a `motion` each row counts as it would have been brought to the middle one with the
/// camera's readout time, and the error of the motion is one more unknown of each view. `invalid_argument` for a window
/// that is out of range; no points where it has fewer than three cameras.
Status reduce_to_intrinsics(const CameraModel& camera, const ReductionParams& params, BundleProblem& window,
                            IntrinsicsWorkspace& workspace, IntrinsicsEquations& equations, ResidualField& field);

}  // namespace ilp
