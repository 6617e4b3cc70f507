#include "fsw/motion/lens_search.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/motion/final_window.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "fsw/shared/navigation_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

constexpr std::array<std::uint32_t, 3> poses_of_pass = {6, 16, 36};
constexpr std::uint32_t most_rounds = 12;
constexpr std::uint32_t pose_steps = 5;
constexpr double short_step = 0.05;        ///< sigmas
constexpr double sufficient_lens = 0.002;  ///< one sigma of k1 with which the search ends early
constexpr double undetermined = 0.5;       ///< of the error before, that is left
constexpr double sigma_of_given_focal = 0.002;
constexpr double least_attitude_sigma_rad = 1e-3;
constexpr double error_of_rates = 0.03;        ///< of the readout time: frames attenuate a swing
constexpr double sufficient_readout_s = 1e-3;  ///< one sigma with which the search ends early
constexpr double no_elevation_sigma_m = 1e6;

bool flight_has_ended(const StripRecord& newest, std::int64_t looked_at) {
  return newest.end == StripEnd::end_of_flight && newest.last_keyframe_id == looked_at;
}

/// The heading's error is about the vertical, which the level's third axis is in the camera's axes.
BundleAttitudePrior attitude_prior(std::uint16_t view, const navigation::MeasuredKeyframe& measured) {
  BundleAttitudePrior prior{.camera = view};
  std::copy_n(measured.q_cam_from_level, 4, prior.q_cam_from_world);
  const Vec3 up = rotation_from_quaternion(measured.q_cam_from_level).col(2);
  const double tilt = std::fmax(measured.tilt_sigma_rad, least_attitude_sigma_rad);
  // Without a heading, turns about the vertical are free.
  const double heading = measured.heading_sigma_rad > 0 ? std::fmax(measured.heading_sigma_rad, tilt) : pi;
  for (int i = 0; i < 3; ++i) {
    const double about_up = up[i] * up[i];
    prior.sigma_rad[i] = std::sqrt((1 - about_up) * tilt * tilt + about_up * heading * heading);
  }
  return prior;
}

MeasuredPlace measured_place(std::uint16_t view, const navigation::MeasuredKeyframe& measured) {
  MeasuredPlace place{.view = view};
  std::copy_n(measured.place_m, 3, place.place_m);
  place.sigma_m[0] = place.sigma_m[1] = measured.horizontal_sigma_m;
  place.sigma_m[2] = measured.vertical_sigma_m > 0 ? measured.vertical_sigma_m : no_elevation_sigma_m;
  return place;
}

MeasuredHeight measured_height(std::uint16_t view, const navigation::MeasuredKeyframe& measured) {
  MeasuredHeight height{.view = view, .height_m = measured.height_m, .sigma_m = measured.height_sigma_m};
  const Vec3 up = rotation_from_quaternion(measured.q_cam_from_level).col(2);
  std::copy_n(up.data(), 3, height.up);
  return height;
}

}  // namespace

LensPrior LensSearch::prior(const CameraModel& nominal) const {
  const MissionParameters& mission = wiring_.mission;
  return prior_of(nominal, {.focal_sigma = mission.camera_known
                                               ? sigma_of_given_focal
                                               : std::fabs(focal_per_field(nominal)) * mission.field_of_view_sigma_rad,
                            .lens = mission.camera_known && mission.lens_known,
                            .readout_sigma_s = mission.readout_sigma_s});
}

bool LensSearch::has_enough(const CameraRecord& camera) const {
  const auto pass = static_cast<std::size_t>(camera.revision);
  return pass < poses_of_pass.size() && work_.posed >= std::max(poses_of_pass[pass], work_.least_posed);
}

/// False: the navigator has not written the keyframe's record yet.
Result<bool> LensSearch::follow_vehicle(const PoseRecord& pose) {
  NavigationRecord record;
  ILP_TAKE(const bool known, measured_at(wiring_.store, wiring_.mission, pose.id, record));
  if (!known) return false;
  if (!work_.placed && has_place(record, wiring_.mission.body)) {
    work_.placed = true;
    work_.origin = place_of(record);
  }
  // What a search that is longer than the list measures at its end does not count.
  static_cast<void>(workspace_.measured.push_back(measured_keyframe(pose, record, wiring_.mission.body, work_.origin)));
  return true;
}

Result<bool> LensSearch::follow_poses(const CameraRecord& camera) {
  if (work_.looked_id == 0) workspace_.measured.clear();
  KeyframeRecord keyframe;
  ILP_TAKE(const Found found, find_next<KeyframeRecord>(wiring_.store, work_.looked_id, keyframe));
  if (found == Found::nothing) {
    StripRecord newest;
    ILP_TAKE(const bool any, found_by(last(wiring_.store, newest)));
    work_.last = any && work_.looked_id > 0 && flight_has_ended(newest, work_.looked_id);
  } else {
    PoseRecord pose;
    ILP_TAKE(const bool posed, find(wiring_.store, keyframe.id, pose));
    const bool settled = pose.state == PoseState::trial || pose.state == PoseState::trial_failed;
    if (!posed || !settled || pose.camera_revision != camera.revision) return false;
    if (pose.state == PoseState::trial) {
      ILP_TAKE(const bool measured, follow_vehicle(pose));
      if (!measured) return false;
    }
    work_.looked_id = keyframe.id;
    if (work_.first_id == 0) work_.first_id = keyframe.id, work_.first_frame_id = keyframe.frame_id;
    if (pose.state == PoseState::trial) ++work_.posed;
    const double held = static_cast<double>(keyframe.frame_id - work_.first_frame_id) * camera.width * camera.height;
    work_.last = static_cast<double>(keyframe.id - work_.first_id) >= wiring_.mission.calibration_patience_keyframes ||
                 held > 0.5 * wiring_.mission.storage_budget_mib * 1048576;
  }
  if (work_.last || has_enough(camera)) {
    work_.solving = true;
    work_.round = 0;
    work_.before = {};
    begin_round(camera_model(camera));
    return true;
  }
  return found != Found::nothing;
}

void LensSearch::begin_round(const CameraModel& camera) {
  work_.camera = camera;
  work_.window_id = 1;
  work_.evidence = {};
}

/// The next six keyframes of a strip with a pose, or what is left of them.
Status LensSearch::collect_window(const CameraRecord& camera) {
  workspace_.ids.clear();
  std::int64_t strip_id = 0;
  for (std::int64_t id = work_.window_id; id <= work_.looked_id; ++id) {
    PoseRecord pose;
    ILP_TAKE(const bool known, find(wiring_.store, id, pose));
    work_.window_id = id + 1;
    if (!known || pose.state != PoseState::trial || pose.camera_revision != camera.revision) continue;
    if (strip_id != 0 && pose.strip_id != strip_id) {
      work_.window_id = id;
      return {};
    }
    strip_id = pose.strip_id;
    static_cast<void>(workspace_.ids.push_back(id));
    if (workspace_.ids.size() < workspace_.ids.capacity()) continue;
    work_.window_id = id;
    return {};
  }
  return {};
}

/// Poses and points of the window, what the vehicle measured at its keyframes, and how their images moved.
Status LensSearch::load_window(const CameraRecord& camera) {
  const FixedVector<std::int64_t, limits::max_calibration_views>& ids = workspace_.ids;
  BundleProblem& window = workspace_.window;
  ILP_TRY(load_final_window(wiring_.store, work_.camera, {ids.data(), ids.size()}, work_.looked_id, window));
  workspace_.places.clear();
  workspace_.heights.clear();
  ILP_TRY(load_motion(wiring_.store, camera_model(camera), camera.sigma_readout_s > 0, {ids.data(), ids.size()},
                      workspace_.motion));
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto view = static_cast<std::uint16_t>(i);
    for (const navigation::MeasuredKeyframe& measured : workspace_.measured) {
      if (measured.keyframe_id != ids[i]) continue;
      if (measured.tilt_sigma_rad > 0) static_cast<void>(window.attitudes.push_back(attitude_prior(view, measured)));
      if (measured.horizontal_sigma_m > 0)
        static_cast<void>(workspace_.places.push_back(measured_place(view, measured)));
      if (measured.tilt_sigma_rad > 0 && measured.height_m > 0 && measured.height_sigma_m > 0)
        static_cast<void>(workspace_.heights.push_back(measured_height(view, measured)));
    }
  }
  return {};
}

Status LensSearch::add_window_to_round(const CameraRecord& camera, Status& event) {
  const std::int64_t begin = work_.window_id;
  ILP_TRY(collect_window(camera));
  if (workspace_.ids.size() < least_window_views) return {};
  const Status loaded = load_window(camera);
  if (is_transient(loaded) && !patience_.abandoned(input())) {
    work_.window_id = begin;
    return loaded;
  }
  if (!loaded.ok()) {
    event = loaded;
    return {};
  }
  IntrinsicsEquations equations;
  const ReductionParams params{.steps = pose_steps,
                               .places = &workspace_.places,
                               .heights = &workspace_.heights,
                               .motion = has_rolling_shutter(camera) ? &workspace_.motion : nullptr};
  const Status reduced = reduce_to_intrinsics(work_.camera, params, workspace_.window, workspace_.equations, equations,
                                              work_.evidence.field);
  if (reduced.ok()) add_window(equations, work_.evidence);
  if (!reduced.ok()) event = reduced;
  return {};
}

Status LensSearch::end_round(CameraRecord& camera, Status& event) {
  CameraRecord nominal;
  ILP_TRY(get_first_camera(wiring_.store, nominal));
  const LensPrior given = prior(camera_model(nominal));
  ++work_.round;
  if (work_.evidence.windows == 0 && work_.before.windows > 0) {
    // The step led too far from the poses: the camera before it stands, and the next pass has better ones.
    work_.before.step.camera = work_.stepped_from;
    return conclude(given, work_.before, camera, event);
  }
  if (work_.evidence.windows == 0 && !work_.last) {
    work_.solving = false;
    work_.least_posed = work_.posed + poses_of_pass[0];
    return {};
  }
  LensSearchWork::Solution found{
      {}, judge(work_.evidence, work_.camera), work_.evidence.windows, work_.evidence.points};
  const CameraCheck& check = found.check;
  const bool unexplained = check.verdict == CameraCheckVerdict::unexplained;
  found.step = step_towards_lens(work_.evidence, work_.camera, given,
                                 unexplained ? std::fmax(check.spread, check.field * check.field) : 1);
  const bool there = !found.step.shortened && found.step.length < short_step;
  if (found.windows == 0 || there || work_.round >= most_rounds) return conclude(given, found, camera, event);
  work_.before = found;
  work_.stepped_from = work_.camera;
  begin_round(found.step.camera);
  return {};
}

Status LensSearch::conclude(const LensPrior& prior, const LensSearchWork::Solution& solution, CameraRecord& camera,
                            Status& event) {
  const LensStep& found = solution.step;
  const CameraCheck& check = solution.check;
  CalibrationRecord said;
  said.id = work_.looked_id;
  said.revision = camera.revision + 1;
  said.keyframes = work_.posed;
  said.windows = solution.windows;
  said.points = solution.points;
  said.rounds = work_.round;
  said.spread = check.spread;
  said.field = check.field;
  said.noise_px = check.noise_px;
  const CameraModel& c = found.camera;
  const double values[intrinsic_count] = {c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
  std::copy_n(values, intrinsic_count, said.intrinsics);
  std::copy_n(found.sigmas.begin(), intrinsic_count, said.sigmas);
  std::copy_n(prior.sigmas.begin(), intrinsic_count, said.prior_sigmas);
  said.readout_s = c.readout_s;
  said.prior_sigma_readout_s = prior.sigmas[readout_unknown];
  const bool readout_known = !(said.prior_sigma_readout_s > 0);
  const double of_rates = error_of_rates * std::fabs(c.readout_s);
  if (!readout_known) said.sigma_readout_s = Vec2(found.sigmas[readout_unknown], of_rates).norm();
  const bool readout_found = readout_known || said.sigma_readout_s < std::fmax(sufficient_readout_s, 2 * of_rates);
  const bool nothing = said.windows == 0;
  const bool lens_known = !(prior.sigmas[0] > 0);
  const bool open_focal = !lens_known && found.sigmas[0] > undetermined * prior.sigmas[0];
  const bool determined = found.lens_sigma < sufficient_lens && check.spread < max_camera_spread && readout_found;
  CameraRecord after = camera_record(c);
  after.revision = said.revision;
  after.frozen = nothing || (camera.revision > 0 &&
                             (work_.last || determined || said.revision > static_cast<int>(poses_of_pass.size())));
  after.source = lens_known ? CameraSource::given : open_focal ? CameraSource::nominal : CameraSource::calibrated;
  after.sigma_focal_px = found.sigmas[0];
  after.sigma_cx_px = found.sigmas[1];
  after.sigma_cy_px = found.sigmas[2];
  std::copy_n(found.covariance.begin(), std::size(after.covariance), after.covariance);
  after.sigma_readout_s = said.sigma_readout_s;
  const bool bent = check.spread > max_camera_spread || check.field > max_camera_field;
  said.verdict = nothing         ? CalibrationVerdict::nothing_seen
                 : !after.frozen ? CalibrationVerdict::searching
                 : bent          ? CalibrationVerdict::unexplained
                 : open_focal    ? CalibrationVerdict::partly
                                 : CalibrationVerdict::ok;
  patience_.begin_writing();
  StepTransaction transaction(wiring_.store, wiring_.checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_camera(wiring_.store, after));
  ILP_TRY(put(wiring_.store, said));
  ILP_TRY(transaction.commit(cursor_, state_, cursor_, state_));
  patience_.end_writing();
  if (after.frozen && said.verdict == CalibrationVerdict::ok) {
    event = {StatusCode::camera_calibrated, said.id, std::llround(1000 * after.fx)};
  } else if (after.frozen) {
    event = {StatusCode::camera_nominal, said.id, static_cast<std::int64_t>(said.verdict)};
  }
  camera = after;
  work_ = {};
  return {};
}

Result<bool> LensSearch::step(CameraRecord& camera, Status& event) {
  if (!work_.solving) return follow_poses(camera);
  if (work_.window_id <= work_.looked_id) {
    ILP_TRY(add_window_to_round(camera, event));
  } else {
    ILP_TRY(end_round(camera, event));
  }
  return true;
}

}  // namespace ilp
