#include "fsw/navigation/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int samples_per_step = 512;
/// A vehicle's measurements may arrive this much later than they were made.
constexpr TimeNs latest_arrival_ns = 2 * ns_per_s;

}  // namespace

constexpr CheckpointForm Navigator::checkpoint = checkpoint_form<State>(component_id);

Navigator::Navigator(Tables store, Clock& clock, const MissionParameters& mission, NavigationSource* source)
    : store_(store), clock_(clock), mission_(mission), source_(source) {}

Status Navigator::restore() {
  const Status status = restore_checkpoint(store_, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(newest_id<NavigationRecord>(store_, newest));
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

void Navigator::keep(const NavigationSample& sample) {
  if (samples_.push_back(sample)) return;
  samples_[oldest_] = sample;
  oldest_ = (oldest_ + 1) % samples_.size();
}

bool Navigator::take_samples(TimeNs until) {
  if (source_ == nullptr) return true;
  for (int i = 0; i < samples_per_step; ++i) {
    NavigationSample sample;
    const Status given = source_->next(until, sample);
    if (given.is(StatusCode::not_ready) || given.is(StatusCode::end_of_stream)) return true;
    if (given.ok() && plausible(sample)) {
      keep(sample);
      continue;
    }
    ++refused_;
    reason_ = given.ok() ? StatusCode::invalid_argument : given.code;
  }
  return false;
}

void Navigator::measure(const KeyframeRecord& keyframe, NavigationRecord& record) const {
  navigation::WindowSamples near;
  for (const NavigationSample& sample : samples_) navigation::add_near(sample, keyframe.time_ns, near);
  navigation::SampleCounts counts;
  const NavigationSample at = navigation::measure_at(near, keyframe.time_ns, counts);
  record.id = keyframe.id;
  record.time_ns = keyframe.time_ns;
  record.samples = counts.offered;
  record.refused = counts.refused;
  record.height_m = at.height_m;
  record.height_sigma_m = at.height_sigma_m;
  std::copy_n(at.q_cam_from_level, 4, record.q_cam_from_level);
  record.tilt_sigma_rad = at.tilt_sigma_rad;
  record.heading_sigma_rad = at.heading_sigma_rad;
  record.longitude_deg = at.longitude_deg;
  record.latitude_deg = at.latitude_deg;
  record.elevation_m = at.elevation_m;
  record.horizontal_sigma_m = at.horizontal_sigma_m;
  record.vertical_sigma_m = at.vertical_sigma_m;
  std::copy_n(at.velocity_m_s, 3, record.velocity_m_s);
  record.velocity_sigma_m_s = at.velocity_sigma_m_s;
}

Status Navigator::measure_keyframe(bool& worked) {
  worked = false;
  KeyframeRecord keyframe;
  const Status found = next(store_, cursor_.first, keyframe);
  if (found.is(StatusCode::not_found)) return {};
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!found.ok() && !damaged) return found;
  NavigationRecord record;
  if (damaged) keyframe.id = record.id = found.a;
  if (!damaged) {
    const bool recorded = source_ == nullptr || source_->recorded();
    const TimeNs until = keyframe.time_ns + navigation::window_ns;
    const bool all = take_samples(recorded ? until : clock_.now());
    worked = !all;
    if (!all || (!recorded && clock_.now() < until + latest_arrival_ns)) return {};
    measure(keyframe, record);
  }
  worked = true;
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, record));
  ILP_TRY(transaction.commit({keyframe.id, cursor_.second}, state_, cursor_));
  return found;
}

void Navigator::add(const PoseRecord& pose, const NavigationRecord& navigation, State& after) const {
  navigation::MeasuredKeyframe measured;
  measured.keyframe_id = pose.id;
  measured.time_ns = navigation.time_ns;
  std::copy_n(pose.centre, 3, measured.centre);
  std::copy_n(pose.q_cam_from_world, 4, measured.q_cam_from_strip);
  measured.ground_distance = pose.ground_distance;
  measured.ground_distance_sigma = pose.ground_distance_sigma;
  measured.height_m = navigation.height_m;
  measured.height_sigma_m = navigation.height_sigma_m;
  std::copy_n(navigation.q_cam_from_level, 4, measured.q_cam_from_level);
  measured.tilt_sigma_rad = navigation.tilt_sigma_rad;
  measured.heading_sigma_rad = navigation.heading_sigma_rad;
  if (navigation.horizontal_sigma_m > 0 && mission_.body != Body::none) {
    const BodyPlace place{navigation.longitude_deg, navigation.latitude_deg, navigation.elevation_m};
    if (!after.placed) after.origin = place;
    after.placed = true;
    offset_from(mission_.body, after.origin, place, measured.place_m);
    measured.horizontal_sigma_m = navigation.horizontal_sigma_m;
    measured.vertical_sigma_m = navigation.vertical_sigma_m;
  }
  std::copy_n(navigation.velocity_m_s, 3, measured.velocity_m_s);
  measured.velocity_sigma_m_s = navigation.velocity_sigma_m_s;
  navigation::add_thinned(measured, after.keyframes);
}

StripFrameRecord Navigator::record_of(const navigation::StripFrame& frame, const State& after,
                                      std::int64_t keyframe_id) const {
  StripFrameRecord record;
  record.id = after.strip_id;
  record.through_keyframe_id = keyframe_id;
  record.verdict = frame.verdict;
  record.metres_per_unit = frame.metres_per_unit;
  record.scale_sigma = frame.scale_sigma;
  RigidTransform turn;
  turn.rotation = frame.level_from_strip;
  const Pose pose = pose_from(turn);
  std::copy_n(pose.q_cam_from_world, 4, record.q_level_from_strip);
  record.tilt_sigma_rad = frame.tilt_sigma_rad;
  record.heading_sigma_rad = frame.heading_sigma_rad;
  if (frame.horizontal_sigma_m > 0) {
    const BodyPlace place =
        place_at(mission_.body, after.origin, {frame.origin_m.x(), frame.origin_m.y(), frame.origin_m.z()});
    record.body = mission_.body;
    record.longitude_deg = place.longitude_deg;
    record.latitude_deg = place.latitude_deg;
    record.elevation_m = place.elevation_m;
    record.horizontal_sigma_m = frame.horizontal_sigma_m;
    record.vertical_sigma_m = frame.vertical_sigma_m;
  }
  record.heights_used = frame.heights.used;
  record.heights_refused = frame.heights.refused;
  record.attitudes_used = frame.attitudes.used;
  record.attitudes_refused = frame.attitudes.refused;
  record.positions_used = frame.positions.used;
  record.positions_refused = frame.positions.refused;
  record.velocities_used = frame.velocities.used;
  record.velocities_refused = frame.velocities.refused;
  return record;
}

/// Poses become final in order of keyframes, so the first one that is provisional stops the walk.
Status Navigator::place_strip(bool& worked) {
  worked = false;
  PoseRecord pose;
  const Status found = next(store_, cursor_.second, pose);
  if (found.is(StatusCode::not_found)) return {};
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!found.ok() && !damaged) return found;
  if (!damaged && pose.state == PoseState::provisional) return {};
  if (damaged) pose.id = found.a;
  worked = true;
  NavigationRecord measured;
  const Status known = get(store_, pose.id, measured);
  if (is_transient(known)) return known;
  const bool useful = !damaged && known.ok() && pose.state == PoseState::final;
  after_ = state_;
  navigation::StripFrame frame;
  if (useful) {
    if (after_.strip_id != pose.strip_id) {
      after_ = {};
      after_.strip_id = pose.strip_id;
    }
    add(pose, measured, after_);
    frame = navigation::estimate_strip_frame(after_.keyframes);
    after_.verdict = frame.verdict;
  }
  const bool contradicts = after_.verdict != state_.verdict && after_.verdict > StripFrameVerdict::nothing_measured;
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  if (useful && frame.verdict != StripFrameVerdict::nothing_measured) {
    ILP_TRY(put(store_, record_of(frame, after_, pose.id)));
  }
  ILP_TRY(transaction.commit({cursor_.first, pose.id}, after_, cursor_, state_));
  if (damaged) return found;
  if (!contradicts) return {};
  return {StatusCode::navigation_contradicts, state_.strip_id, static_cast<std::int64_t>(state_.verdict)};
}

StepResult Navigator::step() {
  if (!mission_.use_navigation) return {};
  StepResult result = work();
  if (!result.status.ok() || refused_ == reported_refused_) return result;
  reported_refused_ = refused_;
  result.status = {StatusCode::navigation_refused, refused_, static_cast<std::int64_t>(reason_)};
  return result;
}

StepResult Navigator::work() {
  bool worked = false;
  Status status = measure_keyframe(worked);
  if (!status.ok() || worked) return {status, true};
  status = place_strip(worked);
  if (!status.ok() || worked) return {status, true};
  // A live source is emptied also while no keyframe asks.
  const bool live = source_ != nullptr && !source_->recorded();
  return {{}, live && !take_samples(clock_.now())};
}

}  // namespace ilp
