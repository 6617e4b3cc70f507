#include "fsw/vision/calibration/calibration_check.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t no_view = 0xFFFF;
constexpr std::uint32_t min_points = 50;
constexpr double first_damping = 1e-9;

struct WindowViews {
  std::size_t count = 0;
  std::array<std::uint16_t, limits::max_bundle_cameras> view_of_camera;
  std::array<RigidTransform, limits::max_calibration_views> cam_from_world;
};

WindowViews newest_views(const BundleProblem& window) {
  WindowViews out;
  out.view_of_camera.fill(no_view);
  const std::size_t cameras = window.cameras.size();
  out.count = std::min(cameras, limits::max_calibration_views);
  for (std::size_t view = 0; view < out.count; ++view) {
    const std::size_t camera = cameras - out.count + view;
    out.view_of_camera[camera] = static_cast<std::uint16_t>(view);
    out.cam_from_world[view] = cam_from_world(window.cameras[camera].pose);
  }
  return out;
}

/// Chooses the track for each point: as many as there is room for, those with the most observations first.
void collect_tracks(const BundleProblem& window, const WindowViews& views, const CentredFrame& frame,
                    CalibrationTracks& tracks) {
  std::array<std::uint8_t, limits::max_bundle_points> seen{};
  for (const BundleObservation& o : window.observations) {
    const std::uint16_t view = views.view_of_camera[o.camera];
    if (view != no_view) seen[o.point] |= only_view(view);
  }
  std::array<std::uint16_t, limits::max_bundle_points> track_of_point;
  track_of_point.fill(no_view);
  tracks.clear();
  for (std::uint32_t wanted = limits::max_calibration_views; wanted >= 2; --wanted) {
    for (std::size_t i = 0; i < window.points.size(); ++i) {
      if (view_count(seen[i]) != wanted) continue;
      CalibrationTrack track;
      const double* x = window.points[i].position;
      const Vec3 in_first = views.cam_from_world[0] * Vec3(x[0], x[1], x[2]);
      if (!(in_first.z() > 1e-9)) continue;
      track.point[0] = in_first.x() / in_first.z();
      track.point[1] = in_first.y() / in_first.z();
      track.point[2] = 1 / in_first.z();
      track.known = true;
      if (!tracks.push_back(track)) break;
      track_of_point[i] = static_cast<std::uint16_t>(tracks.size() - 1);
    }
  }
  for (const BundleObservation& o : window.observations) {
    const std::uint16_t view = views.view_of_camera[o.camera];
    if (view == no_view || track_of_point[o.point] == no_view) continue;
    CalibrationTrack& track = tracks[track_of_point[o.point]];
    track.u[view] = frame.u(o.x);
    track.v[view] = frame.v(o.y);
    track.seen |= only_view(view);
    track.used = track.seen;
  }
}

/// Poses relative to the first view, scaled to a median depth of one.
MetricViews metric_views(const WindowViews& views, const CentredFrame& frame, const CameraModel& given,
                         CalibrationTracks& tracks, double* scratch) {
  MetricViews out;
  out.focal = given.fx / frame.unit_x_px;
  std::size_t count = 0;
  for (const CalibrationTrack& track : tracks) scratch[count++] = track.point[2];
  double unit = 1;
  if (count > 0) {
    std::nth_element(scratch, scratch + count / 2, scratch + count);
    unit = scratch[count / 2];
  }
  for (CalibrationTrack& track : tracks) track.point[2] /= unit;
  const RigidTransform world_from_first = inverse(views.cam_from_world[0]);
  for (std::size_t view = 0; view < views.count; ++view) {
    const RigidTransform pose = compose(views.cam_from_world[view], world_from_first);
    for (int i = 0; i < 9; ++i) out.cameras[view].rotation[i] = pose.rotation(i / 3, i % 3);
    for (int i = 0; i < 3; ++i) out.cameras[view].translation[i] = unit * pose.translation[i];
  }
  return out;
}

ProjectiveCameras projections_of(const MetricViews& views) {
  ProjectiveCameras cameras;
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view) cameras[view] = projection_of(views, view);
  return cameras;
}

/// Drops wrong matches that a robust adjustment left in the window, far off most tracks' worst observations.
void drop_gross_errors(const ProjectiveCameras& cameras, double noise, CalibrationTracks& tracks, double* scratch) {
  std::size_t count = 0;
  for (const CalibrationTrack& track : tracks) {
    double worst = 0;
    for (std::size_t view = 0; view < limits::max_calibration_views; ++view) {
      if (has_view(track.used, view)) worst = std::fmax(worst, squared_residual(cameras[view].p, track, view));
    }
    scratch[count++] = worst;
  }
  std::nth_element(scratch, scratch + count / 2, scratch + count);
  prune_tracks(cameras, 5 * std::fmax(std::sqrt(scratch[count / 2]), noise), tracks);
}

Status check_window(const BundleProblem& window) {
  for (std::size_t i = 0; i < window.observations.size(); ++i) {
    const BundleObservation& o = window.observations[i];
    const bool inside = o.camera < window.cameras.size() && o.point < window.points.size();
    if (!inside || !std::isfinite(o.x) || !std::isfinite(o.y)) {
      return out_of_range(Argument::observation, i);
    }
  }
  return {};
}

}  // namespace

CameraModel calibrated_camera(const CameraModel& nominal, const MetricViews& views) {
  const CentredFrame frame(nominal);
  CameraModel out = nominal;
  out.fx = views.focal * frame.unit_x_px;
  out.fy = views.focal * frame.unit_y_px;
  out.cx = frame.x_px(views.cx);
  out.cy = frame.y_px(views.cy);
  const double grown = out.fx / nominal.fx;
  out.k1 = nominal.k1 * grown * grown;
  out.k2 = nominal.k2 * grown * grown * grown * grown;
  out.p1 = nominal.p1 * grown;
  out.p2 = nominal.p2 * grown;
  return out;
}

Status CalibrationChecker::begin(const CameraModel& given, const BundleProblem& window,
                                 const CalibrationCheckParams& params) {
  phase_ = Phase::idle;
  check_ = {};
  given_ = given;
  params_ = params;
  ILP_TRY(validate(given));
  ILP_TRY(check_window(window));
  const WindowViews from = newest_views(window);
  check_.views = static_cast<std::uint32_t>(from.count);
  if (from.count < 3) return {};
  const CentredFrame frame(given);
  collect_tracks(window, from, frame, w_.tracks);
  check_.points = static_cast<std::uint32_t>(w_.tracks.size());
  if (w_.tracks.size() < min_points) return {};
  views_ = metric_views(from, frame, given, w_.tracks, w_.projective.values.data());
  setup_.views = from.count;
  setup_.sigma_centre = params.sigma_centre * given.width / frame.unit_x_px;
  setup_.noise = params.noise_px / frame.unit_x_px;
  drop_gross_errors(projections_of(views_), setup_.noise, w_.tracks, w_.projective.values.data());
  phase_ = Phase::look;
  return {};
}

/// Ends the check if the geometry alone says that the focal length stays open.
void CalibrationChecker::look() {
  constexpr double margin = 2;  // the adjustment moves the cameras a little
  const CentredFrame frame(given_);
  FocalStep step;
  focal_of_views(w_.tracks, views_, metric_adjustment(setup_, 0, 1), w_.verification.adjustment, step);
  check_.noise_px = step.noise * frame.unit_x_px;
  const double least = step.sigma * (params_.least_noise_px / frame.unit_x_px) / step.noise;
  const bool open = step.valid && least > margin * params_.max_sigma * views_.focal;
  phase_ = open ? Phase::idle : Phase::adjust;
  progress_ = {};
  // The window is adjusted but for the focal length, so that nearly undamped steps lead there.
  progress_.damping = first_damping;
}

void CalibrationChecker::adjust(double robust, Phase next) {
  constexpr std::uint32_t max_iterations = 60;
  const AdjustmentParams adjustment = metric_adjustment(setup_, robust, max_iterations);
  adjust_metric(w_.tracks, views_, adjustment, w_.verification.adjustment, progress_);
  if (progress_.done) phase_ = next;
}

void CalibrationChecker::prune() {
  const ProjectiveCameras cameras = projections_of(views_);
  prune_tracks(cameras, 3.5 * std::fmax(residual_rms(cameras, w_.tracks), 0.2 * setup_.noise), w_.tracks);
  progress_ = {};
  phase_ = Phase::readjust;
}

void CalibrationChecker::state_covariance() {
  const CentredFrame frame(given_);
  metric_covariance(w_.tracks, views_, metric_adjustment(setup_, 0, 1), w_.verification.adjustment, covariance_);
  if (!covariance_.valid || covariance_.points < min_points) {
    phase_ = Phase::idle;
    return;
  }
  verification_ = {};
  w_.verification.progress = {};
  all_tracks_ = false;
  // A result that the covariance already refuses needs no second test.
  const bool hopeless = covariance_.sigma_focal > params_.max_sigma * views_.focal;
  slice_ = hopeless ? verification_slices(setup_.views) : 0;
}

/// One slice of the verification.
void CalibrationChecker::verify() {
  VerificationSlice& out = verification_[slice_];
  bool pending = false;
  if (all_tracks_) {
    verify_focal(slice_, w_.tracks, views_, setup_, w_.verification, out, pending);
  } else {
    estimate_focal(slice_, w_.tracks, views_, setup_, progress_.cost, w_.verification, out, pending);
  }
  if (!pending) ++slice_;
}

void CalibrationChecker::judge() {
  phase_ = Phase::idle;
  const CentredFrame frame(given_);
  const FocalJudgement judgement = judge_focal(verification_, setup_.views, views_, covariance_, progress_.cost,
                                               params_.least_noise_px / frame.unit_x_px);
  if (!judgement.unique && !all_tracks_) {
    // A sample may miss what tells two focal lengths apart. All tracks have the last word.
    all_tracks_ = true;
    slice_ = verification_slices(setup_.views) - other_starts;
    phase_ = Phase::verify;
    return;
  }
  check_.focal_px = views_.focal * frame.unit_x_px;
  check_.sigma_px = judgement.sigma_focal * frame.unit_x_px;
  check_.deviation = (given_.fx - check_.focal_px) / check_.focal_px;
  check_.noise_px = covariance_.noise * frame.unit_x_px;
  check_.consistency = judgement.consistency;
  const double bound_px = params_.max_sigma * check_.focal_px;
  if (covariance_.sigma_focal > params_.max_sigma * views_.focal || !judgement.unique ||
      judgement.consistency > params_.max_consistency || check_.sigma_px > bound_px) {
    return;
  }
  const double off_px = std::fabs(given_.fx - check_.focal_px);
  const bool contradicts =
      off_px > params_.significance * check_.sigma_px && off_px > params_.max_deviation * given_.fx;
  check_.verdict = contradicts ? CalibrationCheckVerdict::contradicts : CalibrationCheckVerdict::agrees;
}

void CalibrationChecker::step(bool& pending) {
  switch (phase_) {
    case Phase::idle:
      break;
    case Phase::look:
      look();
      break;
    case Phase::adjust:
      adjust(2 * setup_.noise, Phase::prune);
      break;
    case Phase::prune:
      prune();
      break;
    case Phase::readjust:
      adjust(0, Phase::covariance);
      break;
    case Phase::covariance:
      phase_ = Phase::verify;
      state_covariance();
      break;
    case Phase::verify:
      if (slice_ < verification_slices(setup_.views)) {
        verify();
      } else {
        judge();
      }
      break;
  }
  pending = phase_ != Phase::idle;
}

Status check_calibration(const CameraModel& given, const BundleProblem& window, const CalibrationCheckParams& params,
                         CalibrationWorkspace& workspace, CalibrationCheck& check) {
  CalibrationChecker checker(workspace);
  check = {};
  ILP_TRY(checker.begin(given, window, params));
  bool pending = true;
  while (pending) checker.step(pending);  // bound: the steps of one check
  check = checker.result();
  return {};
}

}  // namespace ilp
