#include "fsw/motion/camera_calibrator.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include "fsw/base/rng.hpp"
#include "fsw/shared/calibration_wait.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/navigation_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

CalibrationRecord record_of(const CalibrationReport& report, const KeyframeRecord& keyframe) {
  CalibrationRecord record;
  record.id = keyframe.id;
  record.strip_id = keyframe.strip_id;
  record.verdict = report.verdict;
  record.views = report.views;
  if (!report.pairs.empty() && report.pairs.back().second_id == keyframe.id) {
    const CalibrationPair& pair = report.pairs.back();
    record.matches = pair.matches;
    record.inliers = pair.inliers;
    record.gric_f = pair.gric_f;
    record.gric_h = pair.gric_h;
    record.motion_px = pair.motion_px;
    record.pair_model = pair.model;
  }
  record.points = report.points;
  record.focal_px = report.refined_focal_px;
  record.sigma_px = report.sigma_focal_px;
  record.axes_spread_rad = report.axes_spread_rad;
  record.noise_px = report.noise_px;
  record.consistency = report.consistency;
  return record;
}

std::int64_t thousandths(double value) {
  return std::llround(1000 * value);
}

}  // namespace

constexpr CheckpointForm CameraCalibrator::checkpoint = checkpoint_form<CalibratingState>(component_id);
constexpr CheckpointForm CameraCalibrator::second_checkpoint =
    checkpoint_form<StripCheckState>(component_id, stage_of(component_id).state.second);

CameraCalibrator::CameraCalibrator(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, mission, scratch} {}

LastingMemory CameraCalibrator::lasting() const {
  const LastingMemory memory = LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  if (!work_.keeps) return memory;
  const auto& scratch = wiring_.scratch.as<FeatureScratch>();
  return work_.phase == Phase::detect ? keeping_corners(scratch, memory) : keeping_matches(scratch, memory);
}

Status CameraCalibrator::restore() {
  work_.phase = Phase::idle;
  work_.keeps = false;
  workspace_.images.previous_id = 0;
  state_.checking = {};
  work_.check.window_loaded = false;
  ILP_TRY(get_camera(wiring_.store, camera_id, work_.camera));
  Status loaded;
  if (work_.camera.frozen) {
    loaded = restore_checkpoint(wiring_.store, second_checkpoint, cursor_, state_.checking);
    if (loaded.is(StatusCode::checkpoint_lost)) {
      ILP_TRY(newest_id<CalibrationRecord>(wiring_.store, cursor_.first));
      ILP_TRY(strip_check().resume_after_records());
    }
    return loaded;
  }
  loaded = load_checkpoint(wiring_.store, checkpoint, cursor_, state_.calibrating);
  // The state is of a search for another camera, or for one that was found and is lost: the search starts over.
  const bool lost = loaded.is(StatusCode::checkpoint_lost) || loaded.is(StatusCode::store_build);
  if (!lost && !loaded.is(StatusCode::not_found)) return loaded;
  cursor_ = {};
  if (lost) ILP_TRY(newest_id<CalibrationRecord>(wiring_.store, cursor_.first));
  // In place: the state is too large for the stack.
  new (&state_.calibrating) CalibratingState;
  CalibrationParams params;
  params.pair.threshold_px = wiring_.mission.ransac_threshold_px;
  ILP_TRY(SelfCalibration(state_.calibrating.calibration, workspace_.calibration)
              .begin(camera_model(work_.camera), params));
  return lost ? Status{StatusCode::checkpoint_lost, loaded.a, loaded.b} : Status{};
}

Result<bool> CameraCalibrator::pick_keyframe() {
  KeyframeRecord keyframe;
  const Status found = next(wiring_.store, cursor_.first, keyframe);
  if (found.is(StatusCode::not_found)) return end_flight();
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!damaged) ILP_TRY(found);
  if (damaged) keyframe.id = found.a;
  work_.keyframe = keyframe;
  const bool no_use = damaged || work_.patience.given_up(work_.keyframe.id);
  if (!no_use) {
    ILP_TAKE(const bool known, measured_at(wiring_.store, wiring_.mission, work_.keyframe.id, workspace_.navigation));
    if (!known) return false;
  }
  if (no_use || work_.keyframe.strip_id != state_.calibrating.strip_id) {
    SelfCalibration(state_.calibrating.calibration, workspace_.calibration).begin_set();
    state_.calibrating.strip_id = work_.keyframe.strip_id;
  }
  if (no_use) {
    state_.calibrating.calibration.report = {};
    state_.calibrating.calibration.report.verdict = CalibrationVerdict::too_few_matches;
  }
  work_.phase = no_use ? Phase::record : Phase::load;
  if (damaged) return found;
  return true;
}

void CameraCalibrator::measure() {
  work_.phase = Phase::record;
  if (!wiring_.mission.use_navigation) return;
  add_keyframe(work_.keyframe, workspace_.navigation, state_.calibrating.calibration.report.plane,
               camera_model(work_.camera), wiring_.mission.body, state_.calibrating.measured);
}

Status CameraCalibrator::load() {
  // The camera is calibrated once for the whole flight, so all corners are used.
  ILP_TRY(begin_corners_of(wiring_.store, wiring_.mission, work_.keyframe.frame_id, 0,
                           wiring_.scratch.as<FeatureScratch>(), workspace_.images, workspace_.corners));
  workspace_.matches.clear();
  work_.phase = Phase::detect;
  work_.keeps = true;
  return {};
}

Status CameraCalibrator::detect() {
  ILP_TAKE(work_.keeps, find_corners(wiring_.mission, 0, wiring_.scratch.as<FeatureScratch>(), workspace_.images,
                                     workspace_.corners));
  if (!work_.keeps) work_.phase = state_.calibrating.calibration.keyframes.empty() ? Phase::relate : Phase::begin_match;
  return {};
}

Status CameraCalibrator::begin_match() {
  ILP_TRY(begin_matches_to(wiring_.store, wiring_.mission, cursor_.first, work_.keyframe.plane_from_previous,
                           wiring_.scratch.as<FeatureScratch>(), workspace_.images, workspace_.matches));
  work_.phase = Phase::match;
  work_.keeps = true;
  return {};
}

Status CameraCalibrator::match() {
  ILP_TAKE(work_.keeps, find_matches(wiring_.mission, state_.calibrating.calibration.corners,
                                     work_.keyframe.plane_from_previous, wiring_.scratch.as<FeatureScratch>(),
                                     workspace_.images, workspace_.corners, workspace_.matches));
  if (!work_.keeps) work_.phase = Phase::relate;
  return {};
}

Status CameraCalibrator::relate() {
  work_.phase = Phase::calibrate;
  return SelfCalibration(state_.calibrating.calibration, workspace_.calibration)
      .begin_keyframe(work_.keyframe.id, workspace_.corners, workspace_.matches,
                      mix64(wiring_.mission.seed) ^ static_cast<std::uint64_t>(work_.keyframe.id));
}

/// Reports to the operator: once that keyframes wait in vain, and every other reason to wait.
void CameraCalibrator::tell_why(CalibrationVerdict verdict, bool overdue, std::int64_t oldest_id, Status& event) {
  if (!state_.calibrating.overdue_told && overdue) {
    state_.calibrating.overdue_told = true;
    event = {StatusCode::calibration_overdue, work_.keyframe.id, oldest_id};
    return;
  }
  const auto reason = static_cast<std::uint8_t>(verdict);
  const bool known = state_.calibrating.reason_told && state_.calibrating.reason == reason;
  if (known || verdict == CalibrationVerdict::collecting) return;
  state_.calibrating.reason_told = true;
  state_.calibrating.reason = reason;
  event = {StatusCode::calibration_waiting, work_.keyframe.id, reason};
}

Status CameraCalibrator::record_waiting(const CalibrationRecord& said, bool overdue, std::int64_t oldest_id) {
  const Cursor after{work_.keyframe.id, cursor_.second};
  Status event;
  tell_why(said.verdict, overdue, oldest_id, event);
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, said));
  ILP_TRY(transaction.commit(after, state_.calibrating, cursor_));
  work_.event = event;
  return keep_for_next(work_.keyframe.id, workspace_.images);
}

CameraRecord CameraCalibrator::found_camera() const {
  const CalibrationReport& report = state_.calibrating.calibration.report;
  CameraRecord camera = camera_record(report.camera);
  camera.source = CameraSource::calibrated;
  camera.sigma_focal_px = report.sigma_focal_px;
  camera.sigma_cx_px = report.sigma_cx_px;
  camera.sigma_cy_px = report.sigma_cy_px;
  return camera;
}

CameraRecord CameraCalibrator::nominal_camera() const {
  CameraRecord camera = work_.camera;
  camera.frozen = true;
  camera.source = CameraSource::nominal;
  camera.sigma_focal_px =
      camera.fx * std::fabs(focal_per_field(camera_model(camera))) * wiring_.mission.field_of_view_sigma_rad;
  camera.sigma_cx_px = camera.sigma_cy_px = CalibrationParams{}.sigma_centre * camera.width;
  return camera;
}

Status CameraCalibrator::freeze(const CameraRecord& frozen, const CalibrationRecord* said, const Status& event) {
  const Cursor after{said != nullptr ? said->id : cursor_.first, cursor_.second};
  StripCheckState checking;
  StepTransaction transaction(wiring_.store, second_checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_camera(wiring_.store, frozen));
  if (said != nullptr) ILP_TRY(put(wiring_.store, *said));
  ILP_TRY(transaction.commit(after, checking, cursor_, state_.checking));
  work_.camera = frozen;
  work_.event = event;
  return {};
}

Status CameraCalibrator::freeze_found(const CameraRecord& found, const CalibrationRecord* said,
                                      std::int64_t keyframe_id) {
  return freeze(found, said, {StatusCode::camera_calibrated, keyframe_id, thousandths(found.fx)});
}

Status CameraCalibrator::freeze_nominal(const CalibrationRecord* said) {
  const bool newer = said != nullptr && said->verdict != CalibrationVerdict::collecting;
  const auto reason = newer ? static_cast<std::uint8_t>(said->verdict) : state_.calibrating.reason;
  const std::int64_t keyframe_id = said != nullptr ? said->id : cursor_.first;
  const CameraRecord nominal = nominal_camera();
  // A measured focal length that is not good enough by itself may still be better than the nominal one.
  if (is_better_than(nominal.sigma_focal_px / nominal.fx, state_.calibrating.measured)) {
    return freeze_found(measured_camera(camera_model(work_.camera), state_.calibrating.measured), said, keyframe_id);
  }
  return freeze(nominal, said, {StatusCode::camera_nominal, keyframe_id, reason});
}

/// When no other keyframe will come, those that wait need the nominal camera.
Result<bool> CameraCalibrator::end_flight() {
  if (cursor_.first == 0 || wiring_.mission.calibration_fallback != CalibrationFallback::nominal) return false;
  ILP_TAKE(const bool ended, flight_has_ended(wiring_.store, cursor_.first));
  if (!ended) return false;
  work_.patience.begin_writing();
  ILP_TRY(freeze_nominal(nullptr));
  work_.patience.end_writing();
  return true;
}

Status CameraCalibrator::record() {
  CalibrationRecord said = record_of(state_.calibrating.calibration.report, work_.keyframe);
  const CameraModel nominal_model = camera_model(work_.camera);
  const double unit_px = CentredFrame(nominal_model).unit_x_px;
  said.measured_focal_px = state_.calibrating.measured.newest.focal * unit_px;
  said.measured_sigma_px = state_.calibrating.measured.newest.sigma * unit_px;
  const bool calibrated = said.verdict == CalibrationVerdict::ok;
  KeyframeRecord oldest;
  work_.patience.begin_writing();
  ILP_TAKE(const bool known, found_by(next(wiring_.store, 0, oldest)));
  if (!known) oldest = work_.keyframe;
  const bool overdue = !calibrated && waited_out(wiring_.mission, work_.camera, oldest, work_.keyframe);
  const bool nominal = overdue && wiring_.mission.calibration_fallback == CalibrationFallback::nominal;
  if (calibrated || suffices(state_.calibrating.measured)) {
    const CameraRecord found =
        calibrated ? found_camera() : measured_camera(nominal_model, state_.calibrating.measured);
    ILP_TRY(freeze_found(found, &said, work_.keyframe.id));
  } else {
    ILP_TRY(nominal ? freeze_nominal(&said) : record_waiting(said, overdue, oldest.id));
  }
  work_.patience.end_writing();
  work_.phase = Phase::idle;
  return {};
}

Result<bool> CameraCalibrator::advance() {
  Status status;
  switch (work_.phase) {
    case Phase::load:
      status = load();
      break;
    case Phase::detect:
      status = detect();
      break;
    case Phase::begin_match:
      status = begin_match();
      break;
    case Phase::match:
      status = match();
      break;
    case Phase::relate:
      status = relate();
      break;
    case Phase::calibrate: {
      const Result<bool> more = SelfCalibration(state_.calibrating.calibration, workspace_.calibration).step();
      if (!more.value()) work_.phase = Phase::measure;
      status = more.status();
      break;
    }
    case Phase::measure:
      measure();
      break;
    case Phase::record:
      status = record();
      break;
    default:
      return pick_keyframe();
  }
  ILP_TRY(status);
  return true;
}

StepResult CameraCalibrator::calibrate() {
  work_.keeps = false;
  const Result<bool> pending = advance();
  work_.keeps = work_.keeps && pending.ok();
  if (pending.ok()) return {work_.event, pending.value(), work_.keeps ? Then::keep : Then::go_on};
  const Status& fault = pending.status();
  // A permanently damaged record was handled, and is worth an event.
  if (fault.is(StatusCode::record_damaged) && work_.phase == Phase::record) return {fault, true};
  return work_.patience.failed(work_.keyframe.id, fault);
}

StripCheck CameraCalibrator::strip_check() {
  return {{wiring_.store, wiring_.mission, second_checkpoint},
          cursor_,
          state_.checking,
          work_.check,
          work_.patience,
          workspace_.check};
}

StepResult CameraCalibrator::check() {
  const Result<bool> pending = strip_check().step(camera_model(work_.camera), work_.event);
  if (pending.ok()) return {work_.event, pending.value()};
  // The strip counts as an input of its own that may be abandoned.
  return work_.patience.failed(-(cursor_.second + 1), pending.status());
}

StepResult CameraCalibrator::step() {
  work_.event = {};
  return work_.camera.frozen ? check() : calibrate();
}

}  // namespace ilp
