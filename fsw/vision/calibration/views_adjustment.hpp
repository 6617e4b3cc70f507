// Bundle adjustment of a few views whose cameras are not known: projective cameras, or metric ones that share an
// unknown focal length and principal point. Levenberg-Marquardt on the Schur complement (B. Triggs et al., "Bundle
// Adjustment - A Modern Synthesis", 2000), one iteration a call after a first one for the cost at the start.
#pragma once

#include <array>

#include "fsw/vision/calibration/calibration_views.hpp"

namespace ilp {

/// The state of an adjustment between iterations, in addition to its cameras and points.
struct AdjustmentProgress {
  double damping = 1e-3;
  double cost = -1;  ///< half the sum of squared residuals, centred units; negative: nothing done yet
  std::uint32_t iterations = 0;
  bool done = false;
};

struct AdjustmentParams {
  ViewSet views = 0;            ///< views that take part
  std::size_t fixed_view = 0;   ///< the view that never moves
  std::uint32_t min_views = 2;  ///< least number of views for a track to take part
  std::int32_t left_out = -1;   ///< tracks of this block are left out, see track_block
  std::uint32_t max_iterations = 30;
  double relative_tolerance = 1e-7;
  double robust = 0;  ///< Huber bound, centred units; 0: none
  // Metric only
  double centre_weight = 0;  ///< of (c / 1)^2 against squared residuals: (noise / sigma of the principal point)^2
};

inline constexpr std::size_t max_camera_unknowns = 12;
inline constexpr std::size_t shared_unknowns = 3;
inline constexpr std::size_t max_adjustment_system =
    shared_unknowns + max_camera_unknowns * (limits::max_calibration_views - 1);

/// Scratch; it carries nothing from call to call.
struct AdjustmentWorkspace {
  std::array<double, max_adjustment_system * max_adjustment_system> system;
  std::array<double, max_adjustment_system> gradient, step;
  struct Eliminated {
    double inverse[9];  ///< of the point's damped block
    double gradient[3];
  };
  std::array<Eliminated, limits::max_calibration_tracks> eliminated;
  std::array<std::array<double, 3>, limits::max_calibration_tracks> trial_points;
};

/// The block of neighbouring points, of 8, that a track belongs to by its place in its first view.
inline constexpr std::int32_t track_blocks = 8;
[[nodiscard]] std::int32_t track_block(const CalibrationTrack& track);

/// The first call computes the cost; every later one does an iteration on known points and all cameras but the fixed
/// one. Sets progress.done when it has converged, cannot continue, or has used its iterations.
void adjust_projective(CalibrationTracks& tracks, ProjectiveCameras& cameras, const AdjustmentParams& params,
                       AdjustmentWorkspace& workspace, AdjustmentProgress& progress);
void adjust_metric(CalibrationTracks& tracks, MetricViews& views, const AdjustmentParams& params,
                   AdjustmentWorkspace& workspace, AdjustmentProgress& progress);

/// Covariance from the residuals of an adjustment.
struct MetricCovariance {
  bool valid = false;
  double noise = 0;        ///< standard deviation of a coordinate, centred units
  double sigma_focal = 0;  ///< one sigma, centred units, with the principal point as uncertain as its prior
  double sigma_cx = 0, sigma_cy = 0;
  std::uint32_t points = 0, observations = 0;
};
void metric_covariance(const CalibrationTracks& tracks, const MetricViews& views, const AdjustmentParams& params,
                       AdjustmentWorkspace& workspace, MetricCovariance& covariance);

/// Squared distance between projection and observation, centred units; huge behind the camera.
[[nodiscard]] double squared_residual(const double (&p)[12], const CalibrationTrack& track, std::size_t view);
[[nodiscard]] ProjectiveCamera projection_of(const MetricViews& views, std::size_t view);

/// Triangulates the point of a track linearly from the views that use it; false when they do not determine it.
/// `cameras` has one P per view; views outside `posed` are not used.
bool triangulate_linear(const ProjectiveCameras& cameras, ViewSet posed, CalibrationTrack& track);

}  // namespace ilp
