#include "fsw/navigation/navigator.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/shared/find.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/shared/measured_keyframe.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr int samples_per_step = 512;
/// A vehicle's measurements may arrive this much later than they were made.
constexpr TimeNs latest_arrival_ns = 2 * ns_per_s;
/// A strip of so many keyframes without a measurement is reported.
constexpr std::size_t keyframes_without = 5;
/// One sigma of the height that comes with an image, which states none. Heights that scatter more count as they
/// scatter.
constexpr double image_height_share = 0.01;

bool is_measured(const NavigationRecord& at) {
  return at.height_sigma_m > 0 || at.tilt_sigma_rad > 0 || at.horizontal_sigma_m > 0 || at.velocity_sigma_m_s > 0;
}

}  // namespace

constexpr CheckpointForm Navigator::checkpoint = checkpoint_form<State>(component_id);

Navigator::Navigator(Tables store, Clock& clock, const MissionParameters& mission, NavigationSource* source)
    : wiring_{store, clock, mission, source} {}

Status Navigator::restore() {
  const Status status = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(status)) return status;
  std::int64_t newest = 0;
  ILP_TRY(newest_id<NavigationRecord>(wiring_.store, newest));
  cursor_.first = std::max(cursor_.first, newest);
  return status;
}

void Navigator::keep(const NavigationSample& sample) {
  if (workspace_.samples.push_back(sample)) return;
  workspace_.samples[workspace_.oldest] = sample;
  workspace_.oldest = (workspace_.oldest + 1) % workspace_.samples.size();
}

bool Navigator::take_samples(TimeNs until) {
  if (wiring_.source == nullptr) return true;
  for (int i = 0; i < samples_per_step; ++i) {
    NavigationSample sample;
    const Status given = wiring_.source->next(until, sample);
    if (given.is(StatusCode::not_ready) || given.is(StatusCode::end_of_stream)) return true;
    if (given.ok() && plausible(sample)) {
      keep(sample);
      continue;
    }
    ++workspace_.refused;
    workspace_.reason = given.ok() ? StatusCode::invalid_argument : given.code;
  }
  return false;
}

void Navigator::measure(const KeyframeRecord& keyframe, NavigationRecord& record) const {
  navigation::WindowSamples near;
  for (const NavigationSample& sample : workspace_.samples) navigation::add_near(sample, keyframe.time_ns, near);
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

Result<bool> Navigator::measure_keyframe() {
  KeyframeRecord keyframe;
  const Status found = next(wiring_.store, cursor_.first, keyframe);
  if (found.is(StatusCode::not_found)) return false;
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!found.ok() && !damaged) return found;
  NavigationRecord record;
  if (damaged) keyframe.id = record.id = found.a;
  if (!damaged) {
    const bool recorded = wiring_.source == nullptr || wiring_.source->recorded();
    const TimeNs until = keyframe.time_ns + navigation::window_ns;
    if (!take_samples(recorded ? until : wiring_.clock.now())) return true;
    if (!recorded && wiring_.clock.now() < until + latest_arrival_ns) return false;
    measure(keyframe, record);
  }
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, record));
  ILP_TRY(transaction.commit({keyframe.id, cursor_.second}, state_, cursor_));
  if (damaged) return found;
  return true;
}

/// The fix of a keyframe: not known yet is no. A keyframe without a fix has an empty one.
Result<bool> Navigator::fixed_at(std::int64_t keyframe_id, FixRecord& fix) const {
  fix = {};
  if (!wiring_.mission.use_map) return true;
  ILP_TAKE(const Found found, find_next(wiring_.store, keyframe_id - 1, fix));
  if (found == Found::nothing) return false;
  if (found == Found::damaged || fix.id != keyframe_id) fix = {};
  return true;
}

/// The height that came with the image, where the vehicle has measured none.
Status Navigator::take_image_height(std::int64_t keyframe_id, NavigationRecord& measured) const {
  if (measured.height_sigma_m > 0) return {};
  KeyframeRecord keyframe;
  ILP_TAKE(const bool known, find(wiring_.store, keyframe_id, keyframe));
  if (!known || !(keyframe.altitude > 0) || !std::isfinite(keyframe.altitude)) return {};
  measured.time_ns = keyframe.time_ns;
  measured.height_m = keyframe.altitude;
  measured.height_sigma_m = image_height_share * keyframe.altitude;
  return {};
}

Result<bool> Navigator::is_unmeasured(const State& strip) const {
  for (const navigation::MeasuredKeyframe& keyframe : strip.keyframes) {
    NavigationRecord measured;
    ILP_TAKE(const bool known, find(wiring_.store, keyframe.keyframe_id, measured));
    if (known && is_measured(measured)) return false;
  }
  return true;
}

void Navigator::add(const PoseRecord& pose, const NavigationRecord& navigation, const FixRecord& fix,
                    State& after) const {
  const Body body = wiring_.mission.body;
  if (has_place(navigation, body) && !after.placed) {
    after.origin = place_of(navigation);
    after.placed = true;
  }
  const bool fixed = fix.state == FixState::accepted && fix.body == body;
  if (fixed && body != Body::none && !after.placed) {
    after.origin = map_origin_of(fix);
    after.placed = true;
  }
  navigation::MeasuredKeyframe keyframe = measured_keyframe(pose, navigation, body, after.origin);
  // Beside a map, positions lie on a plane as the map does.
  if (wiring_.mission.use_map && has_place(navigation, body))
    plane_from_place(body, after.origin, place_of(navigation), keyframe.place_m);
  if (fixed) keyframe.fix = fix_measurement(fix, after.origin);
  navigation::add_thinned(keyframe, after.keyframes);
}

/// The similarity on the plane about the origin as one to east, north and up at the strip's own place.
BodyPlace Navigator::place_on_plane(const navigation::StripFrame& frame, const State& after,
                                    StripFrameRecord& record) const {
  const Body body = wiring_.mission.body;
  const BodyPlace place =
      place_from_plane(body, after.origin, {frame.origin_m.x(), frame.origin_m.y(), frame.origin_m.z()});
  const double north = plane_north(body, after.origin, place);
  quaternion_from_rotation(rotation_from_vector(Vec3(0, 0, -north)) * frame.level_from_strip,
                           record.q_level_from_strip);
  return place;
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
  if (frame.horizontal_sigma_m > 0 && after.placed) {
    const Vec3& at = frame.origin_m;
    const BodyPlace place = wiring_.mission.use_map
                                ? place_on_plane(frame, after, record)
                                : place_at(wiring_.mission.body, after.origin, {at.x(), at.y(), at.z()});
    record.body = wiring_.mission.body;
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
  record.fixes_used = frame.fixes.used;
  record.fixes_refused = frame.fixes.refused;
  return record;
}

/// Poses become final in order of keyframes, so the first one that is provisional stops the walk.
Result<bool> Navigator::place_strip() {
  PoseRecord pose;
  const Status found = next(wiring_.store, cursor_.second, pose);
  if (found.is(StatusCode::not_found)) return false;
  const bool damaged = found.is(StatusCode::record_damaged);
  if (!found.ok() && !damaged) return found;
  if (!damaged && is_open(pose.state)) return false;
  if (damaged) pose.id = found.a;
  FixRecord fix;
  ILP_TAKE(const bool decided, fixed_at(pose.id, fix));
  if (!decided) return false;
  NavigationRecord measured;
  ILP_TAKE(const bool known, find(wiring_.store, pose.id, measured));
  if (!damaged) ILP_TRY(take_image_height(pose.id, measured));
  const bool uses = wiring_.mission.use_navigation || wiring_.mission.use_map;
  const bool asked = known || wiring_.mission.use_map || measured.height_sigma_m > 0;
  const bool useful = !damaged && asked && pose.state == PoseState::final;
  if (!uses && !useful) {
    cursor_.second = pose.id;
    return true;
  }
  workspace_.after = state_;
  navigation::StripFrame frame;
  if (useful) {
    if (workspace_.after.strip_id != pose.strip_id) {
      workspace_.after = {};
      workspace_.after.strip_id = pose.strip_id;
    }
    add(pose, measured, fix, workspace_.after);
    frame = navigation::estimate_strip_frame(workspace_.after.keyframes);
    workspace_.after.verdict = frame.verdict;
  }
  const bool contradicts =
      workspace_.after.verdict != state_.verdict && workspace_.after.verdict > StripFrameVerdict::nothing_measured;
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (useful && frame.verdict != StripFrameVerdict::nothing_measured) {
    ILP_TRY(put(wiring_.store, record_of(frame, workspace_.after, pose.id)));
  }
  ILP_TRY(transaction.commit({cursor_.first, pose.id}, workspace_.after, cursor_, state_));
  if (damaged) return found;
  const bool measures = wiring_.mission.use_navigation && wiring_.source != nullptr;
  if (useful && measures && state_.keyframes.size() == keyframes_without) {
    ILP_TAKE(const bool unused, is_unmeasured(state_));
    if (unused)
      return Status{StatusCode::navigation_unused, state_.strip_id, static_cast<std::int64_t>(keyframes_without)};
  }
  if (!contradicts) return true;
  return Status{StatusCode::navigation_contradicts, state_.strip_id, static_cast<std::int64_t>(state_.verdict)};
}

StepResult Navigator::step() {
  StepResult result = work();
  if (!result.status.ok() || workspace_.refused == workspace_.reported_refused) return result;
  workspace_.reported_refused = workspace_.refused;
  result.status = {StatusCode::navigation_refused, workspace_.refused, static_cast<std::int64_t>(workspace_.reason)};
  return result;
}

StepResult Navigator::work() {
  const Result<bool> measured = wiring_.mission.use_navigation ? measure_keyframe() : Result<bool>(false);
  if (!measured.ok() || measured.value()) return {measured.status(), true};
  const Result<bool> placed = place_strip();
  if (!placed.ok() || placed.value()) return {placed.status(), true};
  // A live source is emptied also while no keyframe asks.
  const bool live = wiring_.mission.use_navigation && wiring_.source != nullptr && !wiring_.source->recorded();
  return {{}, live && !take_samples(wiring_.clock.now())};
}

}  // namespace ilp
