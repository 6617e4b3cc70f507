#include "fsw/motion/camera_calibrator.hpp"

#include <algorithm>
#include <cmath>
#include <new>

#include "fsw/base/rng.hpp"
#include "fsw/motion/final_window.hpp"
#include "fsw/shared/calibration_wait.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/navigation_on_record.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t least_views_to_check = 3;

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
    checkpoint_form<CheckingState>(component_id, stage_of(component_id).state.second);

CameraCalibrator::CameraCalibrator(Tables store, const MissionParameters& mission, Scratch scratch)
    : store_(store), mission_(mission), scratch_(scratch) {}

LastingMemory CameraCalibrator::lasting() const {
  const LastingMemory memory =
      LastingMemory(camera_, cursor_, calibrating_, checking_).of(*this).at_work(phase_, keyframe_);
  if (!keeps_) return memory;
  const auto& scratch = scratch_.as<FeatureScratch>();
  return phase_ == Phase::detect ? keeping_corners(scratch, memory) : keeping_matches(scratch, memory);
}

Status CameraCalibrator::restore() {
  phase_ = Phase::idle;
  keeps_ = false;
  images_.previous_id = 0;
  checking_ = {};
  ILP_TRY(get_camera(store_, camera_id, camera_));
  Status loaded;
  if (camera_.frozen) {
    loaded = restore_checkpoint(store_, second_checkpoint, cursor_, checking_);
    if (loaded.is(StatusCode::checkpoint_lost)) ILP_TRY(resume_after_records());
    return loaded;
  }
  loaded = load_checkpoint(store_, checkpoint, cursor_, calibrating_);
  // The state is of a search for another camera, or for one that was found and is lost: the search starts over.
  const bool lost = loaded.is(StatusCode::checkpoint_lost) || loaded.is(StatusCode::store_build);
  if (!lost && !loaded.is(StatusCode::not_found)) return loaded;
  cursor_ = {};
  if (lost) ILP_TRY(newest_id<CalibrationRecord>(store_, cursor_.first));
  // In place: the state is too large for the stack.
  new (&calibrating_) CalibratingState;
  CalibrationParams params;
  params.pair.threshold_px = mission_.ransac_threshold_px;
  ILP_TRY(SelfCalibration(calibrating_.calibration, workspace_).begin(camera_model(camera_), params));
  return lost ? Status{StatusCode::checkpoint_lost, loaded.a, loaded.b} : Status{};
}

/// Strips that were checked are not checked again: their points may have been released since.
Status CameraCalibrator::resume_after_records() {
  ILP_TRY(newest_id<CalibrationRecord>(store_, cursor_.first));
  CalibrationCheckRecord check;
  const Status found = last(store_, check);
  if (found.is(StatusCode::not_found)) return {};
  if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
  if (found.ok()) {
    const bool at_end = check.id == calibration_check_id(check.strip_id, true);
    cursor_.second = at_end ? check.strip_id : check.strip_id - 1;
    checking_.checked = !at_end;
    return {};
  }
  StripRecord strip;
  ILP_TRY(newest_id<StripRecord>(store_, strip.id));
  cursor_.second = std::max<std::int64_t>(strip.id - 1, 0);
  return {};
}

Status CameraCalibrator::pick_keyframe(bool& picked) {
  picked = false;
  KeyframeRecord keyframe;
  const Status found = next(store_, cursor_.first, keyframe);
  if (found.is(StatusCode::not_found)) return end_flight(picked);
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!damaged) ILP_TRY(found);
  if (damaged) keyframe.id = found.a;
  keyframe_ = keyframe;
  const bool no_use = damaged || patience_.given_up(keyframe_.id);
  bool waits = false;
  if (!no_use) ILP_TRY(measured_at(store_, mission_, keyframe_.id, navigation_, waits));
  if (waits) return {};
  picked = true;
  if (no_use || keyframe_.strip_id != calibrating_.strip_id) {
    SelfCalibration(calibrating_.calibration, workspace_).begin_set();
    calibrating_.strip_id = keyframe_.strip_id;
  }
  if (no_use) {
    calibrating_.calibration.report = {};
    calibrating_.calibration.report.verdict = CalibrationVerdict::too_few_matches;
  }
  phase_ = no_use ? Phase::record : Phase::load;
  return damaged ? found : Status{};
}

void CameraCalibrator::measure() {
  phase_ = Phase::record;
  if (!mission_.use_navigation) return;
  add_keyframe(keyframe_, navigation_, calibrating_.calibration.report.plane, camera_model(camera_), mission_.body,
               calibrating_.measured);
}

Status CameraCalibrator::load() {
  // The camera is calibrated once for the whole flight, so all corners are used.
  ILP_TRY(begin_corners_of(store_, mission_, keyframe_.frame_id, 0, scratch_.as<FeatureScratch>(), images_, corners_));
  matches_.clear();
  phase_ = Phase::detect;
  keeps_ = true;
  return {};
}

Status CameraCalibrator::detect() {
  ILP_TRY(find_corners(mission_, 0, scratch_.as<FeatureScratch>(), images_, corners_, keeps_));
  if (!keeps_) phase_ = calibrating_.calibration.keyframes.empty() ? Phase::relate : Phase::begin_match;
  return {};
}

Status CameraCalibrator::begin_match() {
  ILP_TRY(begin_matches_to(store_, mission_, cursor_.first, keyframe_.plane_from_previous,
                           scratch_.as<FeatureScratch>(), images_, matches_));
  phase_ = Phase::match;
  keeps_ = true;
  return {};
}

Status CameraCalibrator::match() {
  ILP_TRY(find_matches(mission_, calibrating_.calibration.corners, keyframe_.plane_from_previous,
                       scratch_.as<FeatureScratch>(), images_, corners_, matches_, keeps_));
  if (!keeps_) phase_ = Phase::relate;
  return {};
}

Status CameraCalibrator::relate() {
  phase_ = Phase::calibrate;
  return SelfCalibration(calibrating_.calibration, workspace_)
      .begin_keyframe(keyframe_.id, corners_, matches_,
                      mix64(mission_.seed) ^ static_cast<std::uint64_t>(keyframe_.id));
}

Status CameraCalibrator::find_overdue(bool& overdue, std::int64_t& oldest_id) {
  KeyframeRecord oldest;
  const Status first = next(store_, 0, oldest);
  if (is_transient(first)) return first;
  if (!first.ok()) oldest = keyframe_;
  overdue = waited_out(mission_, camera_, oldest, keyframe_);
  oldest_id = oldest.id;
  return {};
}

/// Reports to the operator: once that keyframes wait in vain, and every other reason to wait.
void CameraCalibrator::tell_why(CalibrationVerdict verdict, bool overdue, std::int64_t oldest_id, Status& event) {
  if (!calibrating_.overdue_told && overdue) {
    calibrating_.overdue_told = true;
    event = {StatusCode::calibration_overdue, keyframe_.id, oldest_id};
    return;
  }
  const auto reason = static_cast<std::uint8_t>(verdict);
  const bool known = calibrating_.reason_told && calibrating_.reason == reason;
  if (known || verdict == CalibrationVerdict::collecting) return;
  calibrating_.reason_told = true;
  calibrating_.reason = reason;
  event = {StatusCode::calibration_waiting, keyframe_.id, reason};
}

Status CameraCalibrator::record_waiting(const CalibrationRecord& said, bool overdue, std::int64_t oldest_id) {
  const Cursor after{keyframe_.id, cursor_.second};
  Status event;
  tell_why(said.verdict, overdue, oldest_id, event);
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, said));
  ILP_TRY(transaction.commit(after, calibrating_, cursor_));
  event_ = event;
  return keep_for_next(keyframe_.id, images_);
}

CameraRecord CameraCalibrator::found_camera() const {
  const CalibrationReport& report = calibrating_.calibration.report;
  CameraRecord camera = camera_record(report.camera);
  camera.source = CameraSource::calibrated;
  camera.sigma_focal_px = report.sigma_focal_px;
  camera.sigma_cx_px = report.sigma_cx_px;
  camera.sigma_cy_px = report.sigma_cy_px;
  return camera;
}

CameraRecord CameraCalibrator::nominal_camera() const {
  CameraRecord camera = camera_;
  camera.frozen = true;
  camera.source = CameraSource::nominal;
  camera.sigma_focal_px =
      camera.fx * std::fabs(focal_per_field(camera_model(camera))) * mission_.field_of_view_sigma_rad;
  camera.sigma_cx_px = camera.sigma_cy_px = CalibrationParams{}.sigma_centre * camera.width;
  return camera;
}

Status CameraCalibrator::freeze(const CameraRecord& frozen, const CalibrationRecord* said, const Status& event) {
  const Cursor after{said != nullptr ? said->id : cursor_.first, cursor_.second};
  const CheckingState checking;
  StepTransaction transaction(store_, second_checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put_camera(store_, frozen));
  if (said != nullptr) ILP_TRY(put(store_, *said));
  ILP_TRY(transaction.commit(after, checking, cursor_, checking_));
  camera_ = frozen;
  event_ = event;
  return {};
}

Status CameraCalibrator::freeze_found(const CameraRecord& found, const CalibrationRecord* said,
                                      std::int64_t keyframe_id) {
  return freeze(found, said, {StatusCode::camera_calibrated, keyframe_id, thousandths(found.fx)});
}

Status CameraCalibrator::freeze_nominal(const CalibrationRecord* said) {
  const bool newer = said != nullptr && said->verdict != CalibrationVerdict::collecting;
  const auto reason = newer ? static_cast<std::uint8_t>(said->verdict) : calibrating_.reason;
  const std::int64_t keyframe_id = said != nullptr ? said->id : cursor_.first;
  const CameraRecord nominal = nominal_camera();
  // A measured focal length that is not good enough by itself may still be better than the nominal one.
  if (is_better_than(nominal.sigma_focal_px / nominal.fx, calibrating_.measured)) {
    return freeze_found(measured_camera(camera_model(camera_), calibrating_.measured), said, keyframe_id);
  }
  return freeze(nominal, said, {StatusCode::camera_nominal, keyframe_id, reason});
}

/// When no other keyframe will come, those that wait need the nominal camera.
Status CameraCalibrator::end_flight(bool& frozen) {
  if (cursor_.first == 0 || mission_.calibration_fallback != CalibrationFallback::nominal) return {};
  bool ended = false;
  ILP_TRY(flight_has_ended(store_, cursor_.first, ended));
  if (!ended) return {};
  patience_.begin_writing();
  ILP_TRY(freeze_nominal(nullptr));
  patience_.end_writing();
  frozen = true;
  return {};
}

Status CameraCalibrator::record() {
  CalibrationRecord said = record_of(calibrating_.calibration.report, keyframe_);
  const CameraModel nominal_model = camera_model(camera_);
  const double unit_px = CentredFrame(nominal_model).unit_x_px;
  said.measured_focal_px = calibrating_.measured.newest.focal * unit_px;
  said.measured_sigma_px = calibrating_.measured.newest.sigma * unit_px;
  const bool calibrated = said.verdict == CalibrationVerdict::ok;
  bool overdue = false;
  std::int64_t oldest_id = 0;
  patience_.begin_writing();
  if (!calibrated) ILP_TRY(find_overdue(overdue, oldest_id));
  const bool nominal = overdue && mission_.calibration_fallback == CalibrationFallback::nominal;
  if (calibrated || suffices(calibrating_.measured)) {
    const CameraRecord found = calibrated ? found_camera() : measured_camera(nominal_model, calibrating_.measured);
    ILP_TRY(freeze_found(found, &said, keyframe_.id));
  } else {
    ILP_TRY(nominal ? freeze_nominal(&said) : record_waiting(said, overdue, oldest_id));
  }
  patience_.end_writing();
  phase_ = Phase::idle;
  return {};
}

Status CameraCalibrator::advance(bool& pending) {
  switch (phase_) {
    case Phase::load:
      return load();
    case Phase::detect:
      return detect();
    case Phase::begin_match:
      return begin_match();
    case Phase::match:
      return match();
    case Phase::relate:
      return relate();
    case Phase::calibrate: {
      bool more = false;
      const Status status = SelfCalibration(calibrating_.calibration, workspace_).step(more);
      if (!more) phase_ = Phase::measure;
      return status;
    }
    case Phase::measure:
      measure();
      return {};
    case Phase::record:
      return record();
    default:
      return pick_keyframe(pending);
  }
}

StepResult CameraCalibrator::calibrate() {
  bool pending = true;
  keeps_ = false;
  const Status status = advance(pending);
  keeps_ = keeps_ && status.ok();
  if (status.ok()) return {event_, pending, keeps_ ? Then::keep : Then::go_on};
  // A permanently damaged record was handled, and is worth an event.
  if (status.is(StatusCode::record_damaged) && pending && phase_ == Phase::record) return {status, true};
  return patience_.failed(keyframe_.id, status);
}

Status CameraCalibrator::follow_strip(bool& picked) {
  picked = false;
  StripRecord strip;
  const Status found = next(store_, cursor_.second, strip);
  if (found.is(StatusCode::not_found)) return {};
  if (found.is(StatusCode::record_damaged) || patience_.given_up(-(cursor_.second + 1))) {
    // The newest one may still be written again.
    const std::int64_t id = found.ok() ? strip.id : found.a;
    StripRecord later;
    const Status more = next(store_, id, later);
    if (more.is(StatusCode::not_found)) return {};
    picked = true;
    return end_strip(id);
  }
  ILP_TRY(found);
  const std::int64_t id = checking_.pose_id == 0 ? strip.first_keyframe_id : checking_.pose_id + 1;
  if (id > strip.last_keyframe_id) {
    picked = strip.end != StripEnd::open;
    return picked ? begin_check(strip, true) : Status{};
  }
  PoseRecord pose;
  // Poses come in the order of ids, and the oldest leave the store in time.
  const Status posed = next(store_, id - 1, pose);
  if (posed.is(StatusCode::not_found) || (posed.ok() && pose.state == PoseState::provisional)) return {};
  const bool damaged = posed.is(StatusCode::record_damaged);
  if (!damaged) ILP_TRY(posed);
  if (damaged) pose.id = posed.a;
  if (damaged) pose.state = PoseState::failed;
  picked = true;
  checking_.pose_id = std::min(pose.id, strip.last_keyframe_id);
  if (pose.id > strip.last_keyframe_id) return {};
  if (pose.state == PoseState::final) ++checking_.posed;
  // The window after them may still see their points.
  const std::uint32_t wanted = limits::max_calibration_views + window_length(mission_);
  const bool window_full = !checking_.checked && checking_.posed == wanted;
  return window_full ? begin_check(strip, false) : Status{};
}

Status CameraCalibrator::collect_keyframes(const StripRecord& strip, bool at_end) {
  checked_ids_.clear();
  const std::int64_t step = at_end ? -1 : 1;
  std::int64_t id = at_end ? strip.last_keyframe_id : strip.first_keyframe_id;
  while (id >= strip.first_keyframe_id && id <= strip.last_keyframe_id) {
    PoseRecord pose;
    const Status known = get(store_, id, pose);
    if (is_transient(known)) return known;
    if (known.ok() && pose.state == PoseState::final && !checked_ids_.push_back(id)) break;
    id += step;
  }
  std::sort(checked_ids_.begin(), checked_ids_.end());
  return {};
}

Status CameraCalibrator::begin_check(const StripRecord& strip, bool at_end) {
  ILP_TRY(collect_keyframes(strip, at_end));
  if (checked_ids_.size() < least_views_to_check) return end_strip(strip.id);
  check_ = {};
  check_.id = calibration_check_id(strip.id, at_end);
  check_.strip_id = strip.id;
  check_.first_keyframe_id = checked_ids_[0];
  check_.last_keyframe_id = checked_ids_.back();
  const CameraModel camera = camera_model(camera_);
  const CalibrationCheckParams params;
  Status prepared =
      load_final_window(store_, camera, {checked_ids_.data(), checked_ids_.size()}, checking_.pose_id, window_);
  if (prepared.ok()) prepared = checker_.begin(camera, window_, params);
  if (is_transient(prepared) && !patience_.given_up(-(cursor_.second + 1))) return prepared;
  if (!prepared.ok()) {
    // This strip gives no answer; an empty window expresses that.
    ILP_TRY(load_final_window(store_, camera, {}, 0, window_));
    ILP_TRY(checker_.begin(camera, window_, params));
    event_ = prepared;
  }
  phase_ = Phase::check;
  return {};
}

Status CameraCalibrator::end_strip(std::int64_t strip_id) {
  patience_.begin_writing();
  const Cursor after{cursor_.first, strip_id};
  StepTransaction transaction(store_, second_checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(transaction.commit(after, CheckingState{}, cursor_, checking_));
  patience_.end_writing();
  return {};
}

Status CameraCalibrator::write_check() {
  const CalibrationCheck& said = checker_.result();
  check_.verdict = said.verdict;
  check_.views = said.views;
  check_.points = said.points;
  check_.focal_px = said.focal_px;
  check_.sigma_px = said.sigma_px;
  check_.deviation = said.deviation;
  check_.noise_px = said.noise_px;
  check_.consistency = said.consistency;
  const bool at_end = check_.id == calibration_check_id(check_.strip_id, true);
  CheckingState after_state = checking_;
  after_state.checked = true;
  if (at_end) after_state = {};
  patience_.begin_writing();
  const Cursor after{cursor_.first, at_end ? check_.strip_id : cursor_.second};
  StepTransaction transaction(store_, second_checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, check_));
  ILP_TRY(transaction.commit(after, after_state, cursor_, checking_));
  patience_.end_writing();
  phase_ = Phase::idle;
  if (said.verdict == CalibrationCheckVerdict::contradicts) {
    event_ = {StatusCode::calibration_contradicted, check_.strip_id, thousandths(said.focal_px)};
  }
  return {};
}

StepResult CameraCalibrator::check() {
  Status status;
  bool pending = true;
  switch (phase_) {
    case Phase::check: {
      bool more = false;
      checker_.step(more);
      if (!more) phase_ = Phase::write_check;
      break;
    }
    case Phase::write_check:
      status = write_check();
      break;
    default:
      status = follow_strip(pending);
      break;
  }
  if (status.ok()) return {event_, pending};
  // The strip counts as an input of its own that may be abandoned.
  return patience_.failed(-(cursor_.second + 1), status);
}

StepResult CameraCalibrator::step() {
  event_ = {};
  return camera_.frozen ? check() : calibrate();
}

}  // namespace ilp
