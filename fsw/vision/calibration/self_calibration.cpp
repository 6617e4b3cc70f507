#include "fsw/vision/calibration/self_calibration.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/calibration/absolute_quadric.hpp"
#include "fsw/vision/calibration/calibration_views.hpp"
#include "fsw/vision/calibration/calibration_workspace.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/sequence.hpp"

namespace ilp {
namespace {

constexpr std::uint16_t no_calibration_track = 0xFFFF;
constexpr std::uint64_t pair_stream = 0xCA11B;
constexpr std::uint32_t min_common_points = 50;
// Rounds of adjustment, each after the outliers of the previous round were dropped.
constexpr std::uint32_t projective_rounds = 3;
constexpr std::uint32_t metric_rounds = 3;

Status check(const CalibrationParams& p) {
  const bool views = p.min_views >= 3 && p.min_views <= p.max_views && p.max_views <= limits::max_calibration_views;
  const bool field = p.min_field_of_view_rad > 0.05 && p.min_field_of_view_rad < p.max_field_of_view_rad &&
                     p.max_field_of_view_rad < 3;
  const bool rest = p.min_gric_gain >= 0 && p.min_motion_px >= 0 && p.sigma_centre > 0 && p.noise_px > 0 &&
                    p.least_noise_px >= 0 && p.max_noise_px > 0 && p.max_sigma > 0 && p.max_sigma_of_few > 0 &&
                    p.max_consistency >= 1;
  if (!views || !field || !rest) return out_of_range(Argument::calibration_parameters);
  return {};
}

Status check(const Matches& matches, std::size_t corners_a, const Corners& corners_b) {
  FixedVector<std::uint8_t, limits::max_corners> seen_a;
  FixedVector<std::uint8_t, limits::max_corners> seen_b;
  static_cast<void>(seen_a.resize(corners_a));
  static_cast<void>(seen_b.resize(corners_b.size()));
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const Match& m = matches[i];
    const bool inside = m.a < corners_a && m.b < corners_b.size();
    if (!inside || seen_a[m.a] != 0 || seen_b[m.b] != 0 || !std::isfinite(m.xb) || !std::isfinite(m.yb)) {
      return out_of_range(Argument::match, i);
    }
    seen_a[m.a] = seen_b[m.b] = 1;
  }
  for (std::size_t i = 0; i < corners_b.size(); ++i) {
    if (!std::isfinite(corners_b[i].x) || !std::isfinite(corners_b[i].y)) {
      return out_of_range(Argument::corner, i);
    }
  }
  return {};
}

double focal_of_field(const CameraModel& nominal, double field_rad) {
  const double unit = 0.5 * (nominal.width + nominal.height);
  return 0.5 * nominal.width / unit * det_cos(0.5 * field_rad) / det_sin(0.5 * field_rad);
}

Vec2 ideal_of(const CameraModel& nominal, const Corner& corner) {
  const Vec2 pixel(corner.x, corner.y);
  return nominal.has_distortion() ? ideal_from_pixel(nominal, pixel) : pixel;
}

double median_motion(const PointPairs& pairs, double* scratch) {
  std::size_t count = 0;
  for (const PointPair& p : pairs) {
    scratch[count++] = std::sqrt((p.xb - p.xa) * (p.xb - p.xa) + (p.yb - p.ya) * (p.yb - p.ya));
  }
  if (count == 0) return 0;
  std::nth_element(scratch, scratch + count / 2, scratch + count);
  return scratch[count / 2];
}

/// Some camera in the range would see this homography by turning alone: K^-1 H K is nearly orthogonal.
bool may_be_rotation(const Mat3& homography, const CameraModel& nominal, const CalibrationParams& params) {
  constexpr int steps = 24;
  constexpr double tolerance = 0.02;  // of the baseline over the distance
  const CentredFrame frame(nominal);
  Mat3 pixel_from_centred;
  pixel_from_centred << frame.unit_x_px, 0, frame.middle_x_px, 0, frame.unit_y_px, frame.middle_y_px, 0, 0, 1;
  Mat3 centred_from_pixel;
  centred_from_pixel << 1 / frame.unit_x_px, 0, -frame.middle_x_px / frame.unit_x_px, 0, 1 / frame.unit_y_px,
      -frame.middle_y_px / frame.unit_y_px, 0, 0, 1;
  const Mat3 centred = centred_from_pixel * homography * pixel_from_centred;
  const double low = focal_of_field(nominal, params.max_field_of_view_rad);
  const double high = focal_of_field(nominal, params.min_field_of_view_rad);
  for (int i = 0; i <= steps; ++i) {
    const double f = low + (high - low) * i / steps;
    Mat3 m = centred;
    m.row(2) *= f;
    m.col(2) /= f;
    const double scale = det_cbrt(m.determinant());
    if (!(std::fabs(scale) > 1e-12)) continue;
    m /= scale;
    if ((m.transpose() * m - Mat3::Identity()).norm() < tolerance) return true;
  }
  return false;
}

/// Drops tracks that ended, with at most `longest` observations, to make room.
void drop_ended(CalibrationTracks& tracks, std::size_t newest, std::uint32_t longest) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    if (!has_view(tracks[i].seen, newest) && view_count(tracks[i].seen) <= longest) continue;
    tracks[kept++] = tracks[i];
  }
  static_cast<void>(tracks.resize(kept));
}

}  // namespace

Status SelfCalibration::begin(const CameraModel& nominal, const CalibrationParams& params) {
  ILP_TRY(validate(nominal));
  ILP_TRY(check(params));
  ILP_TRY(validate(params.pair));
  s_.nominal = nominal;
  s_.params = params;
  s_.report = {};
  begin_set();
  return {};
}

void SelfCalibration::begin_set() {
  s_.phase = CalibrationPhase::idle;
  s_.keyframes.clear();
  s_.pairs.clear();
  s_.tracks.clear();
  s_.corners.clear();
  s_.new_corners.clear();
  s_.matches.clear();
  s_.posed = 0;
  s_.round = s_.slice = 0;
  s_.projective = {};
  s_.metric = {};
  s_.progress = {};
  s_.covariance = {};
  s_.verification = {};
}

Status SelfCalibration::begin_keyframe(std::int64_t keyframe_id, const Corners& corners,
                                       const Matches& matches_to_previous, std::uint64_t seed) {
  if (s_.phase != CalibrationPhase::idle) return StatusCode::not_ready;
  s_.matches.clear();
  const bool first = s_.keyframes.empty();
  ILP_TRY(check(first ? s_.matches : matches_to_previous, s_.corners.size(), corners));
  if (!first) s_.matches = matches_to_previous;
  s_.new_corners = corners;
  refine_corners(s_.matches, s_.new_corners);
  s_.keyframe_id = keyframe_id;
  s_.seed = mix64(s_.params.pair.seed ^ mix64(seed ^ pair_stream));
  s_.report = {};
  s_.phase = CalibrationPhase::relate;
  return {};
}

Status SelfCalibration::add_keyframe(std::int64_t keyframe_id, const Corners& corners,
                                     const Matches& matches_to_previous, std::uint64_t seed,
                                     CalibrationReport& report) {
  ILP_TRY(begin_keyframe(keyframe_id, corners, matches_to_previous, seed));
  ILP_TRY(do_all([this] { return step(); }));
  report = s_.report;
  return {};
}

Result<bool> SelfCalibration::step() {
  Status status;
  switch (s_.phase) {
    case CalibrationPhase::idle:
      break;
    case CalibrationPhase::relate:
      status = relate();
      break;
    case CalibrationPhase::pair:
      status = reconstruct();
      break;
    case CalibrationPhase::resect:
      resect();
      break;
    case CalibrationPhase::adjust_projective:
      adjust_projectively();
      break;
    case CalibrationPhase::upgrade:
      upgrade();
      break;
    case CalibrationPhase::adjust_metric:
      adjust_metrically(false);
      break;
    case CalibrationPhase::readjust_metric:
      adjust_metrically(true);
      break;
    case CalibrationPhase::verify:
      verify();
      break;
  }
  if (!status.ok()) s_.phase = CalibrationPhase::idle;
  ILP_TRY(status);
  return s_.phase != CalibrationPhase::idle;
}

void SelfCalibration::end(CalibrationVerdict verdict) {
  s_.report.verdict = verdict;
  s_.report.pairs = s_.pairs;
  s_.report.views = static_cast<std::uint32_t>(s_.keyframes.size());
  s_.phase = CalibrationPhase::idle;
}

void SelfCalibration::restart_with_new() {
  s_.keyframes.clear();
  s_.pairs.clear();
  s_.tracks.clear();
  static_cast<void>(s_.keyframes.push_back(s_.keyframe_id));
  s_.corners = s_.new_corners;
}

void SelfCalibration::slide() {
  for (std::size_t i = 1; i < s_.keyframes.size(); ++i) s_.keyframes[i - 1] = s_.keyframes[i];
  s_.keyframes.pop_back();
  for (std::size_t i = 1; i < s_.pairs.size(); ++i) s_.pairs[i - 1] = s_.pairs[i];
  s_.pairs.pop_back();
  for (CalibrationTrack& track : s_.tracks) {
    for (std::size_t view = 1; view < limits::max_calibration_views; ++view) {
      track.u[view - 1] = track.u[view];
      track.v[view - 1] = track.v[view];
    }
    track.seen = static_cast<ViewSet>(track.seen >> 1U);
  }
  // A track that the last view and all but one of the others do not see is of no use.
  drop_ended(s_.tracks, s_.keyframes.size() - 1, 1);
}

void SelfCalibration::extend_tracks() {
  const std::size_t previous = s_.keyframes.size() - 1;
  const std::size_t newest = previous + 1;
  const CentredFrame frame(s_.nominal);
  if (s_.tracks.size() + s_.matches.size() > s_.tracks.capacity()) drop_ended(s_.tracks, previous, 2);
  w_.track_of_corner.fill(no_calibration_track);
  for (std::size_t i = 0; i < s_.tracks.size(); ++i) {
    if (has_view(s_.tracks[i].seen, previous)) w_.track_of_corner[s_.tracks[i].corner] = static_cast<std::uint16_t>(i);
  }
  const auto observe = [&](CalibrationTrack& track, std::size_t view, const Corner& corner) {
    const Vec2 ideal = ideal_of(s_.nominal, corner);
    track.u[view] = frame.u(ideal.x());
    track.v[view] = frame.v(ideal.y());
    track.seen |= only_view(view);
  };
  for (std::size_t k = 0; k < s_.matches.size(); ++k) {
    if (w_.projective.inliers[k] == 0) continue;
    const Match& m = s_.matches[k];
    std::uint16_t at = w_.track_of_corner[m.a];
    if (at == no_calibration_track) {
      CalibrationTrack fresh;
      observe(fresh, previous, s_.corners[m.a]);
      // A full table keeps its tracks, which are the longer ones.
      if (!s_.tracks.push_back(fresh)) continue;
      at = static_cast<std::uint16_t>(s_.tracks.size() - 1);
    }
    observe(s_.tracks[at], newest, s_.new_corners[m.b]);
    s_.tracks[at].corner = m.b;
  }
}

Status SelfCalibration::relate() {
  if (s_.keyframes.empty()) {
    restart_with_new();
    end(CalibrationVerdict::collecting);
    return {};
  }
  if (s_.keyframes.size() == s_.params.max_views) slide();
  ProjectiveWorkspace& ws = w_.projective;
  ws.pairs.clear();
  for (const Match& m : s_.matches) {
    const Vec2 a = ideal_of(s_.nominal, s_.corners[m.a]);
    const Vec2 b = ideal_of(s_.nominal, s_.new_corners[m.b]);
    static_cast<void>(ws.pairs.push_back({a.x(), a.y(), b.x(), b.y(), m.score}));
  }
  RansacParams params = s_.params.pair;
  params.seed = s_.seed;
  CalibrationPair pair;
  pair.first_id = s_.keyframes.back();
  pair.second_id = s_.keyframe_id;
  pair.matches = static_cast<std::uint32_t>(ws.pairs.size());
  pair.motion_px = median_motion(ws.pairs, ws.values.data());
  HomographyResult plane;
  ILP_TRY(estimate_homography(ws.pairs, params, ws.two_view, ws.inliers, plane));
  FundamentalResult epipolar;
  ILP_TRY(estimate_fundamental(ws.pairs, params, ws.two_view, ws.inliers, epipolar));
  // The plane of all inliers: relief is noise to it.
  const CentredFrame frame(s_.nominal);
  if (epipolar.found && fit_plane_pair(ws.pairs, ws.inliers, frame, s_.report.plane)) {
    s_.report.plane.motion = pair.motion_px / frame.unit_x_px;
  }
  pair.inliers = epipolar.inliers;
  pair.gric_f = epipolar.gric_inliers;
  pair.gric_h = epipolar.gric_homography;
  pair.verdict = CalibrationVerdict::ok;
  const bool flat = pair.gric_h - pair.gric_f < s_.params.min_gric_gain * pair.inliers;
  if (epipolar.found) pair.model = flat ? PairModel::homography : PairModel::fundamental;
  if (!epipolar.found) {
    pair.verdict = CalibrationVerdict::too_few_matches;
  } else if (pair.motion_px < s_.params.min_motion_px) {
    pair.verdict = CalibrationVerdict::too_little_parallax;
  } else if (flat) {
    const bool turned = plane.found && may_be_rotation(plane.homography, s_.nominal, s_.params);
    pair.verdict = turned ? CalibrationVerdict::too_little_parallax : CalibrationVerdict::planar;
  }
  static_cast<void>(s_.pairs.push_back(pair));
  if (pair.verdict != CalibrationVerdict::ok) {
    end(pair.verdict);
    restart_with_new();
    return {};
  }
  extend_tracks();
  static_cast<void>(s_.keyframes.push_back(s_.keyframe_id));
  s_.corners = s_.new_corners;
  if (s_.keyframes.size() < s_.params.min_views) {
    end(CalibrationVerdict::collecting);
    return {};
  }
  s_.phase = CalibrationPhase::pair;
  return {};
}

Status SelfCalibration::reconstruct() {
  for (CalibrationTrack& track : s_.tracks) {
    track.used = track.seen;
    track.known = false;
  }
  const std::size_t second = choose_second_view(s_.tracks, s_.keyframes.size());
  if (second == 0) {
    end(CalibrationVerdict::too_few_matches);
    return {};
  }
  RansacParams params = s_.params.pair;
  params.seed = mix64(s_.seed);
  ILP_TAKE(const bool found,
           reconstruct_pair(CentredFrame(s_.nominal), second, params, s_.tracks, w_.projective, s_.projective));
  if (!found) {
    end(CalibrationVerdict::inconsistent);
    return {};
  }
  s_.posed = static_cast<ViewSet>(only_view(0) | only_view(second));
  s_.phase = CalibrationPhase::resect;
  return {};
}

void SelfCalibration::resect() {
  constexpr std::uint32_t min_inliers = 25;
  const CentredFrame frame(s_.nominal);
  // The views between the first two come first: they see most of the known points.
  std::size_t view = 0;
  while (view < s_.keyframes.size() && has_view(s_.posed, view)) ++view;
  const double bound = 2 * s_.params.pair.threshold_px / frame.unit_x_px;
  if (!resect_projective(view, s_.posed, bound, min_inliers, s_.seed, s_.tracks, w_.projective, s_.projective)) {
    end(CalibrationVerdict::inconsistent);
    return;
  }
  s_.posed |= only_view(view);
  if (view_count(s_.posed) < s_.keyframes.size()) return;
  s_.progress = {};
  s_.round = 0;
  s_.phase = CalibrationPhase::adjust_projective;
}

void SelfCalibration::adjust_projectively() {
  const double threshold = s_.params.pair.threshold_px / CentredFrame(s_.nominal).unit_x_px;
  AdjustmentParams params;
  params.views = s_.posed;
  params.robust = 0.5 * threshold;
  params.max_iterations = 25;
  params.relative_tolerance = 1e-5;
  adjust_projective(s_.tracks, s_.projective, params, w_.verification.adjustment, s_.progress);
  if (!s_.progress.done) return;
  // Tracks that were not good enough at the start get a second chance with better cameras.
  for (CalibrationTrack& track : s_.tracks) {
    if (!track.known) track.known = triangulate_linear(s_.projective, s_.posed, track);
  }
  ++s_.round;
  const double bound = (s_.round < projective_rounds ? 4 : 2) * threshold;
  if (prune_tracks(s_.projective, bound, s_.tracks) < min_common_points) {
    end(CalibrationVerdict::too_few_matches);
    return;
  }
  s_.progress = {};
  if (s_.round >= projective_rounds) s_.phase = CalibrationPhase::upgrade;
}

RefinementSetup SelfCalibration::setup() const {
  const CentredFrame frame(s_.nominal);
  RefinementSetup out;
  out.views = s_.keyframes.size();
  out.sigma_centre = s_.params.sigma_centre * s_.nominal.width / frame.unit_x_px;
  out.noise = s_.params.noise_px / frame.unit_x_px;
  return out;
}

double SelfCalibration::max_sigma() const {
  return s_.keyframes.size() < s_.params.full_views ? s_.params.max_sigma_of_few : s_.params.max_sigma;
}

void SelfCalibration::upgrade() {
  QuadricParams params;
  params.min_focal = focal_of_field(s_.nominal, s_.params.max_field_of_view_rad);
  params.max_focal = focal_of_field(s_.nominal, s_.params.min_field_of_view_rad);
  AbsoluteQuadric quadric;
  constexpr double min_share_in_front = 0.7;
  if (!find_absolute_quadric(s_.projective, s_.posed, params, quadric) ||
      upgrade_to_metric(s_.projective, s_.posed, quadric, s_.tracks, w_.projective.values.data(), s_.metric) <
          min_share_in_front) {
    end(CalibrationVerdict::inconsistent);
    return;
  }
  s_.report.start_focal_px = quadric.focal * CentredFrame(s_.nominal).unit_x_px;
  s_.progress = {};
  s_.round = 0;
  s_.phase = CalibrationPhase::adjust_metric;
}

void SelfCalibration::adjust_metrically(bool last) {
  const double threshold = s_.params.pair.threshold_px / CentredFrame(s_.nominal).unit_x_px;
  AdjustmentParams params = metric_adjustment(setup(), last ? 0 : 0.5 * threshold, 60);
  adjust_metric(s_.tracks, s_.metric, params, w_.verification.adjustment, s_.progress);
  if (!s_.progress.done) return;
  if (last) {
    metric_covariance(s_.tracks, s_.metric, params, w_.verification.adjustment, s_.covariance);
    s_.verification = {};
    s_.slice = 0;
    w_.verification.progress = {};
    s_.phase = CalibrationPhase::verify;
    return;
  }
  ProjectiveCameras cameras;
  for (std::size_t view = 0; view < limits::max_calibration_views; ++view)
    cameras[view] = projection_of(s_.metric, view);
  // Beyond 3.5 standard deviations of the remaining residuals.
  const double bound = std::fmin(4 * threshold, std::fmax(3.5 * residual_rms(cameras, s_.tracks), 0.2 * threshold));
  if (prune_tracks(cameras, bound, s_.tracks) < min_common_points) {
    end(CalibrationVerdict::too_few_matches);
    return;
  }
  s_.progress = {};
  if (++s_.round >= metric_rounds) s_.phase = CalibrationPhase::readjust_metric;
}

void SelfCalibration::verify() {
  // A result that the covariance already refuses needs no second test.
  const bool hopeless = !s_.covariance.valid || s_.covariance.sigma_focal > max_sigma() * s_.metric.focal;
  if (!hopeless && s_.slice < verification_slices(s_.keyframes.size())) {
    const bool more = verify_focal(s_.slice, s_.tracks, s_.metric, setup(), w_.verification, s_.verification[s_.slice]);
    if (!more) ++s_.slice;
    return;
  }
  conclude();
}

void SelfCalibration::conclude() {
  const CentredFrame frame(s_.nominal);
  const CalibrationParams& p = s_.params;
  CalibrationReport& r = s_.report;
  r.points = s_.covariance.points;
  r.observations = s_.covariance.observations;
  r.noise_px = s_.covariance.noise * frame.unit_x_px;
  r.axes_spread_rad = axes_spread_rad(s_.metric, s_.keyframes.size());
  r.refined_focal_px = s_.metric.focal * frame.unit_x_px;
  r.refined_sigma_px = s_.covariance.sigma_focal * frame.unit_x_px;
  r.sigma_focal_px = r.refined_sigma_px;
  if (s_.covariance.valid && r.noise_px > p.max_noise_px) {
    end(CalibrationVerdict::inconsistent);
    return;
  }
  if (!s_.covariance.valid || s_.covariance.sigma_focal > max_sigma() * s_.metric.focal) {
    end(CalibrationVerdict::critical_motion);
    return;
  }
  const FocalJudgement judgement = judge_focal(s_.verification, s_.keyframes.size(), s_.metric, s_.covariance,
                                               s_.progress.cost, p.least_noise_px / frame.unit_x_px);
  r.consistency = judgement.consistency;
  r.sigma_focal_px = judgement.sigma_focal * frame.unit_x_px;
  const bool in_range = s_.metric.focal > focal_of_field(s_.nominal, p.max_field_of_view_rad) &&
                        s_.metric.focal < focal_of_field(s_.nominal, p.min_field_of_view_rad);
  if (!in_range || !judgement.unique || judgement.consistency > p.max_consistency) {
    end(CalibrationVerdict::inconsistent);
    return;
  }
  if (judgement.sigma_focal > max_sigma() * s_.metric.focal) {
    end(CalibrationVerdict::critical_motion);
    return;
  }
  r.camera = calibrated_camera(s_.nominal, s_.metric);
  const double inflation = judgement.sigma_focal / s_.covariance.sigma_focal;
  r.sigma_cx_px = inflation * s_.covariance.sigma_cx * frame.unit_x_px;
  r.sigma_cy_px = inflation * s_.covariance.sigma_cy * frame.unit_y_px;
  end(CalibrationVerdict::ok);
}

}  // namespace ilp
