#include "fsw/motion/structure_and_motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

#include "fsw/base/rng.hpp"
#include "fsw/motion/keyframe_motion.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/navigation_on_record.hpp"
#include "fsw/shared/new_command.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/depths_seen.hpp"
#include "fsw/vision/multiview/ground_below.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t failures_until_lost = 2;
// A keyframe is tried against the posed keyframes so many before the newest one, in this order, the second one where
// the newest keyframe holds less than a fourth of the corners of the one before: then clouds hide most of its ground.
constexpr std::uint32_t most_attempts = 3;
constexpr std::uint32_t attempts[2][most_attempts] = {{0, 1, 2}, {1, 2, 0}};
constexpr std::size_t poor_share = 4;
// Poses that left the window are final. In a strip, at most a window and the failures within it are not.
constexpr std::int64_t looked_back = 4 * static_cast<std::int64_t>(limits::max_bundle_cameras);

using Plane = double[9];

/// The end of a strip, as an input that may be abandoned.
std::int64_t end_of(std::int64_t strip_id) {
  return -strip_id;
}

void set_identity(Plane& plane) {
  for (int i = 0; i < 9; ++i) plane[i] = i % 4 == 0 ? 1 : 0;
}

/// The sequence's verdicts have the same numbers.
constexpr PoseVerdict verdict_of(SequenceVerdict verdict) {
  return static_cast<PoseVerdict>(verdict);
}
static_assert(verdict_of(SequenceVerdict::waiting) == PoseVerdict::waiting &&
              verdict_of(SequenceVerdict::too_few_matches) == PoseVerdict::too_few_matches &&
              verdict_of(SequenceVerdict::two_view_failed) == PoseVerdict::two_view_failed &&
              verdict_of(SequenceVerdict::resection_failed) == PoseVerdict::resection_failed &&
              verdict_of(SequenceVerdict::implausible) == PoseVerdict::implausible);

SequenceParams sequence_params(const MissionParameters& mission, const CameraRecord& camera, double altitude,
                               const NavigationRecord& measured) {
  SequenceParams params;
  std::copy(std::begin(camera.covariance), std::end(camera.covariance), params.lens_covariance.begin());
  params.window_keyframes = window_length(mission);
  params.two_view.threshold_px = mission.ransac_threshold_px;
  params.resection_threshold_px = mission.resection_threshold_px;
  params.first_height = altitude > 0 ? altitude : 0;
  if (measured.height_sigma_m > 0) params.first_height = measured.height_m;
  if (measured.tilt_sigma_rad > 0) std::copy_n(measured.q_cam_from_level, 4, params.q_first);
  return params;
}

/// The overlap checker writes a damaged record of the strip again, with its next keyframe or its end.
Result<bool> has_ended(Reader<StripRecord> store, std::int64_t strip_id, std::int64_t looked_at) {
  if (strip_id == 0) return false;
  StripRecord strip;
  ILP_TAKE(const bool known, find<StripRecord>(store, strip_id, strip));
  return known && strip.end != StripEnd::open && strip.last_keyframe_id <= looked_at;
}

/// Whether the strip of `keyframe` has poses by this revision of the camera already.
Result<bool> has_world(Reader<PoseRecord> store, const KeyframeRecord& keyframe, std::int32_t revision) {
  if (keyframe.index == 0) return false;
  for (std::int64_t id = std::max<std::int64_t>(keyframe.id - looked_back, 1); id < keyframe.id; ++id) {
    PoseRecord pose;
    ILP_TAKE(const bool known, find(store, id, pose));
    const bool posed = pose.state != PoseState::failed && pose.state != PoseState::trial_failed;
    if (known && posed && pose.strip_id == keyframe.strip_id && pose.camera_revision == revision) return true;
  }
  return false;
}

/// Predicts pixels of the posed keyframe `from_id` in the posed one `to_id`; false where a record is missing.
Result<bool> plane_between(Reader<KeyframeRecord> store, std::int64_t from_id, std::int64_t to_id, Plane& plane) {
  set_identity(plane);
  // At most one keyframe between two posed ones has failed.
  constexpr std::int64_t most_steps = (most_attempts - 1) * static_cast<std::int64_t>(failures_until_lost);
  if (to_id - from_id > most_steps) return false;
  for (std::int64_t id = from_id + 1; id <= to_id; ++id) {
    KeyframeRecord keyframe;
    ILP_TAKE(const bool known, find(store, id, keyframe));
    if (!known) return false;
    compose_planes(keyframe.plane_from_previous, plane, plane);
  }
  return true;
}

/// It never changes, as long as the camera does not.
bool is_final(const PoseRecord& pose) {
  return pose.state == PoseState::final || pose.state == PoseState::trial;
}

Status fail_pose(StorePart<Writes<PoseRecord>> store, std::int64_t strip_id, std::int64_t keyframe_id,
                 const CameraRecord& camera) {
  PoseRecord pose;
  ILP_TAKE(const bool known, find<PoseRecord>(store, keyframe_id, pose));
  if (pose.camera_revision != camera.revision) pose = {};
  if (known && is_final(pose)) return {};
  pose.id = keyframe_id;
  pose.strip_id = strip_id;
  pose.state = camera.frozen ? PoseState::failed : PoseState::trial_failed;
  pose.camera_revision = camera.revision;
  return put(store, pose);
}

Status fail_provisional_poses(StorePart<Writes<PoseRecord>> store, std::int64_t newest, const CameraRecord& camera) {
  for (std::int64_t id = std::max<std::int64_t>(newest - looked_back, 1); id <= newest; ++id) {
    PoseRecord pose;
    ILP_TAKE(const bool known, find<PoseRecord>(store, id, pose));
    if (known && pose.state == PoseState::provisional) ILP_TRY(fail_pose(store, pose.strip_id, id, camera));
  }
  return {};
}

void fill(const SequenceReport& report, PoseRecord& pose) {
  pose.verdict = verdict_of(report.verdict);
  pose.matches = report.matches;
  pose.pair_inliers = report.two_view.inliers;
  pose.known_points = report.known_points;
  pose.inliers = report.resection_inliers > 0 ? report.resection_inliers : report.two_view.inliers;
  pose.points = report.points;
  pose.rms_px = report.rms_px;
  pose.gric_e = report.two_view.gric_e;
  pose.gric_h = report.two_view.gric_h;
  pose.parallax_px = report.two_view.median_parallax_px;
  pose.sigma_rotation_rad = report.two_view.sigma_rotation_rad;
  pose.sigma_direction_rad = report.two_view.sigma_direction_rad;
  pose.scale_step = report.scale_step;
  pose.two_view_verdict = report.two_view.verdict;
}

PoseState failed_state(const CameraRecord& camera) {
  return camera.frozen ? PoseState::failed : PoseState::trial_failed;
}

Status append_point(const CameraModel& camera, const FinalPoint& point, StructureAndMotion::FinalsWorkspace& finals) {
  StructurePoint head{};
  for (int i = 0; i < 3; ++i) head.position[i] = point.position[i];
  head.error_px = point.error_px;
  head.observations = static_cast<std::uint32_t>(point.observations.size());
  const std::size_t size = sizeof(head) + head.observations * sizeof(StructureObservation);
  const std::size_t begin = finals.points.size();
  // A batch that is too large loses its last points; the count on record says how many there are.
  if (!finals.points.resize(begin + size))
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(begin + size),
            static_cast<std::int64_t>(limits::max_structure_bytes)};
  std::uint8_t* to = finals.points.data() + begin;
  std::memcpy(to, &head, sizeof(head));
  to += sizeof(head);
  for (const FinalObservation& seen : point.observations) {
    const Vec2 pixel = pixel_from_ideal(camera, Vec2(static_cast<double>(seen.x), static_cast<double>(seen.y)));
    StructureObservation observation{};
    observation.keyframe_id = seen.keyframe_id;
    observation.x = static_cast<float>(pixel.x());
    observation.y = static_cast<float>(pixel.y());
    std::memcpy(to, &observation, sizeof(observation));
    to += sizeof(observation);
  }
  ++finals.point_count;
  return {};
}

}  // namespace

constexpr CheckpointForm StructureAndMotion::checkpoint = checkpoint_form<State>(component_id);

StructureAndMotion::StructureAndMotion(Tables store, const MissionParameters& mission, Scratch scratch)
    : wiring_{store, mission, scratch} {}

LastingMemory StructureAndMotion::lasting() const {
  const Tracks& tracks = state_.sequence.tracks;
  const LastingMemory whole = LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_)
                                  .without(memory_between(tracks.end(), tracks.data() + Tracks::capacity()));
  // Where the last keyframe to be matched cannot be read, Phase::begin_match takes an earlier report back into the
  // state.
  const bool at_rest = work_.phase == Phase::load || work_.phase == Phase::detect || work_.phase == Phase::match;
  const LastingMemory memory = at_rest ? whole.at_rest() : whole;
  if (!work_.keeps) return memory;
  if (work_.phase == Phase::detect) return keeping_corners(wiring_.scratch.as<FeatureScratch>(), memory);
  if (work_.phase == Phase::match) return keeping_matches(wiring_.scratch.as<FeatureScratch>(), memory);
  const TwoViewProgress& pair = wiring_.scratch.as<SequenceWorkspace>().two_view.progress;
  return state_.sequence.phase == SequencePhase::relating ? memory.keeping(pair) : memory;
}

Status StructureAndMotion::restore() {
  work_.phase = Phase::idle;
  work_.keeps = false;
  workspace_.images.previous_id = 0;
  ILP_TRY(get_camera(wiring_.store, camera_id, work_.camera));
  const Status status = load_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  const bool lost = status.is(StatusCode::checkpoint_lost);
  if (!lost && !status.is(StatusCode::not_found)) return status;
  // In place: a State is megabytes, too large for the stack.
  new (&state_) State;
  state_.camera_revision = work_.camera.revision;
  cursor_ = {};
  if (!lost) return {};
  ILP_TRY(newest_id<PoseRecord>(wiring_.store, cursor_.first));
  state_.examined_id = cursor_.first;
  if (!work_.camera.frozen) {
    ILP_TRY(start_over());
    return status;
  }
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(fail_provisional_poses(wiring_.store, cursor_.first, work_.camera));
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  return status;
}

/// The camera was changed: all poses so far were trials.
Status StructureAndMotion::start_over() {
  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  StructureRecord structure;
  // bound: the keyframes so far
  for (Status found = next(wiring_.store, 0, structure); !found.is(StatusCode::not_found);
       found = next(wiring_.store, 0, structure)) {
    if (found.is(StatusCode::record_damaged)) structure.id = found.a;
    if (!found.is(StatusCode::record_damaged)) ILP_TRY(found);
    ILP_TRY(erase<StructureRecord>(wiring_.store, structure.id));
  }
  new (&state_) State;
  state_.camera_revision = work_.camera.revision;
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  work_.patience.end_writing();
  return {};
}

Status StructureAndMotion::begin_strip() {
  ILP_TAKE(const bool known_world, has_world(wiring_.store, work_.keyframe, state_.camera_revision));
  state_.strip_id = work_.keyframe.strip_id;
  state_.posed_keyframe_id = 0;
  state_.failures = 0;
  // A strip has one world. If it is lost, the rest of the strip cannot be placed in it.
  state_.lost = known_world;
  state_.end_commanded = false;
  state_.baseline_errors = {};
  set_identity(state_.last_from_posed);
  return {};
}

Status StructureAndMotion::begin_keyframe(bool no_use, const NavigationRecord& measured) {
  PoseRecord pose;
  ILP_TAKE(const bool known, find<PoseRecord>(wiring_.store, work_.keyframe.id, pose));
  work_.on_record = known && pose.camera_revision == state_.camera_revision;
  if (state_.strip_id == 0) ILP_TRY(begin_strip());
  if (no_use) {
    state_.sequence.report = {};
    state_.sequence.report.verdict = SequenceVerdict::too_few_matches;
  }
  if (no_use || state_.lost) {
    work_.phase = Phase::record;
    return {};
  }
  if (state_.posed_keyframe_id == 0) {
    const SequenceParams params = sequence_params(wiring_.mission, work_.camera, work_.keyframe.altitude, measured);
    state_.scale_source = params.first_height > 0 ? ScaleSource::altimeter : ScaleSource::first_baseline;
    Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
    ILP_TRY(sequence.begin_strip(camera_model(work_.camera), params));
  }
  work_.phase = Phase::load;
  return {};
}

Result<bool> StructureAndMotion::pick() {
  ILP_TRY(get_camera(wiring_.store, camera_id, work_.camera));
  if (work_.camera.revision != state_.camera_revision) {
    ILP_TRY(start_over());
    return true;
  }
  ILP_TAKE(const bool at_end, has_ended(wiring_.store, state_.strip_id, state_.examined_id));
  KeyframeRecord keyframe;
  const Status found = at_end ? Status{} : next(wiring_.store, state_.examined_id, keyframe);
  if (found.is(StatusCode::not_found)) return false;
  const bool damaged = found.is(StatusCode::record_damaged);
  if (damaged) {
    keyframe.id = found.a;
    keyframe.strip_id = state_.strip_id;
  } else {
    ILP_TRY(found);
  }
  // Where the strips differ, the end of the open one cannot be read.
  if (at_end || (state_.strip_id != 0 && keyframe.strip_id != state_.strip_id)) {
    ILP_TRY(finish_strip());
    return true;
  }
  work_.keyframe = keyframe;
  work_.subject = keyframe.id;
  // Nothing else of it is read then, so that the verdict does not fail for the same reason.
  const bool no_use = damaged || work_.patience.abandoned(keyframe.id);
  NavigationRecord measured;
  work_.shutter = {};
  if (!no_use) {
    ILP_TAKE(const bool known, measured_at(wiring_.store, wiring_.mission, work_.keyframe.id, measured));
    if (!known) return false;
    ILP_TAKE(const bool ready, keyframe_motion(wiring_.store, work_.camera, work_.keyframe, work_.shutter));
    if (!ready) return false;
  }
  ILP_TRY(begin_keyframe(no_use, measured));
  ILP_TRY(found);
  return true;
}

Status StructureAndMotion::load() {
  ILP_TRY(begin_corners_of(wiring_.store, wiring_.mission, work_.keyframe.frame_id, work_.keyframe.degraded,
                           wiring_.scratch.as<FeatureScratch>(), workspace_.images, workspace_.corners, work_.shutter));
  workspace_.matches.clear();
  work_.phase = Phase::detect;
  work_.keeps = true;
  return {};
}

Status StructureAndMotion::detect() {
  ILP_TAKE(work_.keeps, find_corners(wiring_.mission, work_.keyframe.degraded, wiring_.scratch.as<FeatureScratch>(),
                                     workspace_.images, workspace_.corners));
  if (work_.keeps) return {};
  work_.detected = workspace_.corners.size();
  const Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  work_.newest_is_poor =
      sequence.can_go_back_to(1) && poor_share * sequence.count_corners(0) < sequence.count_corners(1);
  work_.attempt = 0;
  work_.phase = state_.posed_keyframe_id == 0 ? Phase::relate : Phase::begin_match;
  return {};
}

Status StructureAndMotion::begin_match() {
  ILP_TRY(workspace_.corners.resize(work_.detected) ? Status{} : Status{StatusCode::assertion_failed});
  workspace_.matches.clear();
  if (back() > 0) return begin_match_to_older();
  compose_planes(work_.keyframe.plane_from_previous, state_.last_from_posed, workspace_.predicted);
  ILP_TRY(begin_matches_to(wiring_.store, wiring_.mission, state_.posed_keyframe_id, workspace_.predicted,
                           wiring_.scratch.as<FeatureScratch>(), workspace_.images, workspace_.matches));
  work_.phase = Phase::match;
  work_.keeps = true;
  return {};
}

Status StructureAndMotion::match() {
  const Corners& from = back() > 0 ? workspace_.older_corners : state_.sequence.corners;
  ILP_TAKE(work_.keeps, find_matches(wiring_.mission, from, workspace_.predicted, wiring_.scratch.as<FeatureScratch>(),
                                     workspace_.images, workspace_.corners, workspace_.matches));
  if (!work_.keeps) work_.phase = Phase::relate;
  return {};
}

/// An older keyframe that cannot be read is passed over.
Status StructureAndMotion::begin_match_to_older() {
  const Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  const std::int64_t older_id = sequence.cameras()[sequence.cameras().size() - 1 - back()].keyframe_id;
  Plane to_newest;
  ILP_TAKE(bool usable, plane_between(wiring_.store, older_id, state_.posed_keyframe_id, to_newest));
  compose_planes(state_.last_from_posed, to_newest, workspace_.predicted);
  compose_planes(work_.keyframe.plane_from_previous, workspace_.predicted, workspace_.predicted);
  sequence.corners_of(back(), workspace_.older_corners);
  if (usable) {
    ILP_TAKE(usable,
             found_by(begin_matches_to(wiring_.store, wiring_.mission, older_id, workspace_.predicted,
                                       wiring_.scratch.as<FeatureScratch>(), workspace_.images, workspace_.matches)));
  }
  work_.keeps = usable;
  work_.phase = usable ? Phase::match : try_next() ? Phase::begin_match : Phase::record;
  return {};
}

std::uint32_t StructureAndMotion::back() const {
  return attempts[work_.newest_is_poor ? 1 : 0][work_.attempt];
}

bool StructureAndMotion::try_next() {
  const Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  if (back() == 0) work_.newest_report = sequence.report();
  while (work_.attempt + 1 < most_attempts) {
    ++work_.attempt;
    if (sequence.can_go_back_to(back())) return true;
  }
  state_.sequence.report = work_.newest_report;
  return false;
}

Status StructureAndMotion::write_camera(const SequenceCamera& camera, bool final_pose) {
  PoseRecord pose;
  ILP_TAKE(const bool known, find<PoseRecord>(wiring_.store, camera.keyframe_id, pose));
  if (pose.camera_revision != state_.camera_revision) pose = {};
  // Repeated after a damaged checkpoint: the result is the same, and other components have used it.
  if (known && is_final(pose)) return {};
  pose.camera_revision = state_.camera_revision;
  pose.id = camera.keyframe_id;
  pose.strip_id = state_.strip_id;
  if (camera.keyframe_id == work_.keyframe.id && work_.phase == Phase::record) fill(state_.sequence.report, pose);
  pose.scale_source = state_.scale_source;
  pose.state = !final_pose ? PoseState::provisional : work_.camera.frozen ? PoseState::final : PoseState::trial;
  const Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  const bool is_first = camera.keyframe_id == sequence.cameras()[0].keyframe_id;
  if (!is_first && pose.verdict == PoseVerdict::waiting && sequence.begun()) pose.verdict = PoseVerdict::ok;
  // No structure began. A strip of a single keyframe relates to nothing.
  if (final_pose && !sequence.begun()) {
    pose.state = failed_state(work_.camera);
    if (!is_first) pose.verdict = PoseVerdict::two_view_failed;
  }
  // The same holds for a pair whose motion is ambiguous.
  if (final_pose && state_.sequence.first_pair.ambiguous) {
    pose.state = failed_state(work_.camera);
    pose.verdict = PoseVerdict::ambiguous;
  }
  for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = camera.pose.q_cam_from_world[i];
  for (int i = 0; i < 3; ++i) pose.centre[i] = camera.pose.centre[i];
  for (int i = 0; i < 3; ++i) pose.sigma[i] = camera.sigma_position[i];
  for (int i = 0; i < 21; ++i) pose.step_covariance[i] = camera.step_covariance[i];
  for (int i = 0; i < 21; ++i) pose.covariance[i] = camera.covariance[i];
  DepthsSeen depths;
  if (depths_seen(state_.sequence, camera, workspace_.depths, depths)) {
    pose.min_depth = depths.least;
    pose.max_depth = depths.largest;
    if (final_pose)
      pose.lens_depth_sigma = sequence.depth_error_of_lens(camera, 2 / (1 / depths.least + 1 / depths.largest));
  }
  GroundBelow ground;
  if (ground_below(state_.sequence.tracks, pose.centre, ground)) {
    pose.ground_distance = ground.distance;
    pose.ground_distance_sigma = ground.sigma;
  }
  if (has_rolling_shutter(work_.camera)) {
    ShutterRecord shutter;
    ILP_TAKE(const bool recorded, find<ShutterRecord>(wiring_.store, camera.keyframe_id, shutter));
    static_cast<void>(recorded);
    ILP_TRY(find_baseline_errors(wiring_.store, work_.camera, pose, state_.baseline_errors));
    add_errors(shutter_error_rad(work_.camera, shutter), state_.baseline_errors, pose);
  }
  return put(wiring_.store, pose);
}

Status StructureAndMotion::write_finals() {
  auto& finals = wiring_.scratch.as<FinalsWorkspace>();
  Sequence sequence(state_.sequence, finals.sequence);
  SequenceCamera camera;
  std::int64_t newest_final = 0;
  while (sequence.take_final_camera(camera)) {  // bound: the cameras of the window
    ILP_TRY(write_camera(camera, true));
    newest_final = camera.keyframe_id;
  }
  if (newest_final == 0) return {};
  finals.points.clear();
  finals.point_count = 0;
  FinalPoint point;
  const CameraModel model = camera_model(work_.camera);
  while (sequence.take_final_point(point)) {  // bound: limits::max_tracks
    const Status appended = append_point(model, point, finals);
    if (!appended.ok() && !appended.is(StatusCode::capacity_exceeded)) return appended;
  }
  StructureRecord structure;
  ILP_TAKE(const bool repeated, find<StructureRecord>(wiring_.store, newest_final, structure));
  // Its points may have been released since.
  if (repeated) return {};
  structure.id = newest_final;
  structure.strip_id = state_.strip_id;
  structure.count = finals.point_count;
  structure.points.bytes = static_cast<std::uint32_t>(finals.points.size());
  ILP_TRY(put(wiring_.store, structure));
  if (finals.points.empty()) return {};
  return write_blob<StructureRecord>(wiring_.store, "points", structure.id, 0,
                                     {finals.points.data(), finals.points.size()});
}

Status StructureAndMotion::record_success() {
  Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  for (const SequenceCamera& camera : sequence.cameras()) ILP_TRY(write_camera(camera, false));
  for (const std::int64_t id : sequence.dropped()) {
    ILP_TRY(fail_pose(wiring_.store, state_.strip_id, id, work_.camera));
  }
  state_.posed_keyframe_id = work_.keyframe.id;
  state_.failures = 0;
  set_identity(state_.last_from_posed);
  ILP_TRY(keep_for_next(work_.keyframe.id, workspace_.images));
  return write_finals();
}

Status StructureAndMotion::abandon_strip() {
  state_.lost = true;
  if (state_.end_commanded) return {};
  state_.end_commanded = true;
  // The pose on record was made before, together with the command. A trial may fail by its camera.
  if (work_.on_record || !work_.camera.frozen) return {};
  CommandRecord command;
  command.time_ns = work_.keyframe.time_ns;
  command.reason = StripEnd::pose_lost;
  command.after_frame_id = work_.keyframe.frame_id;
  return put_new_command(wiring_.store, command);
}

Status StructureAndMotion::record_failure() {
  PoseRecord pose;
  const bool final_before = work_.on_record && get(wiring_.store, work_.keyframe.id, pose).ok() && is_final(pose);
  pose = {};
  pose.id = work_.keyframe.id;
  pose.strip_id = state_.strip_id;
  pose.state = failed_state(work_.camera);
  pose.camera_revision = state_.camera_revision;
  pose.verdict = PoseVerdict::too_few_matches;
  if (!state_.lost) fill(state_.sequence.report, pose);
  if (!final_before) ILP_TRY(put(wiring_.store, pose));
  if (state_.lost) return abandon_strip();
  if (state_.posed_keyframe_id == 0) return {};
  ++state_.failures;
  compose_planes(work_.keyframe.plane_from_previous, state_.last_from_posed, state_.last_from_posed);
  if (state_.failures < failures_until_lost) return {};
  const Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  if (sequence.begun() || sequence.can_begin()) return abandon_strip();
  // There is no structure, and no pair to begin one: the keyframes so far are abandoned and the next one starts over.
  for (const SequenceCamera& camera : sequence.cameras())
    ILP_TRY(fail_pose(wiring_.store, state_.strip_id, camera.keyframe_id, work_.camera));
  state_.posed_keyframe_id = 0;
  state_.failures = 0;
  set_identity(state_.last_from_posed);
  return {};
}

Status StructureAndMotion::record() {
  const SequenceVerdict verdict = state_.sequence.report.verdict;
  const bool success = !state_.lost && (verdict == SequenceVerdict::ok || verdict == SequenceVerdict::waiting);
  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (work_.shutter.id != 0) ILP_TRY(put(wiring_.store, work_.shutter));
  ILP_TRY(success ? record_success() : record_failure());
  state_.examined_id = work_.keyframe.id;
  ILP_TRY(transaction.commit({std::max(cursor_.first, state_.examined_id), cursor_.second}, state_, cursor_));
  work_.patience.end_writing();
  work_.phase = Phase::idle;
  return {};
}

/// The structure of a short strip may still have to begin.
Status StructureAndMotion::finish_strip() {
  work_.subject = end_of(state_.strip_id);
  const bool open = state_.posed_keyframe_id != 0 && !work_.patience.abandoned(work_.subject);
  if (!open || !Sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>()).begin_with_best_pair())
    return end_strip();
  work_.phase = Phase::finish;
  return {};
}

Status StructureAndMotion::end_strip() {
  work_.subject = end_of(state_.strip_id);
  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (work_.patience.abandoned(work_.subject)) {
    ILP_TRY(fail_provisional_poses(wiring_.store, state_.examined_id, work_.camera));
  } else if (state_.posed_keyframe_id != 0) {
    Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
    ILP_TRY(sequence.flush());
    for (const std::int64_t id : sequence.dropped()) {
      ILP_TRY(fail_pose(wiring_.store, state_.strip_id, id, work_.camera));
    }
    ILP_TRY(write_finals());
  }
  state_.strip_id = 0;
  state_.posed_keyframe_id = 0;
  ILP_TRY(transaction.commit(cursor_, state_, cursor_));
  work_.patience.end_writing();
  work_.phase = Phase::idle;
  return {};
}

Status StructureAndMotion::extend_sequence() {
  Sequence sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>());
  const Status status = sequence.step();
  work_.keeps = status.ok() && sequence.keeps();
  if (!sequence.idle()) return status;
  if (work_.phase == Phase::finish) {
    ILP_TRY(status);
    return end_strip();
  }
  const SequenceVerdict verdict = state_.sequence.report.verdict;
  const bool related = verdict == SequenceVerdict::ok || verdict == SequenceVerdict::waiting;
  work_.phase = status.ok() && !related && try_next() ? Phase::begin_match : Phase::record;
  return status;
}

Status StructureAndMotion::advance() {
  switch (work_.phase) {
    case Phase::idle:
      break;
    case Phase::load:
      return load();
    case Phase::detect:
      return detect();
    case Phase::begin_match:
      return begin_match();
    case Phase::match:
      return match();
    case Phase::relate:
      work_.phase = Phase::sequence;
      return Sequence(state_.sequence, wiring_.scratch.as<SequenceWorkspace>())
          .begin_keyframe_on(back(), work_.keyframe.id, workspace_.corners, workspace_.matches,
                             mix64(wiring_.mission.seed) ^ static_cast<std::uint64_t>(work_.keyframe.id));
    case Phase::sequence:
    case Phase::finish:
      return extend_sequence();
    case Phase::record:
      return record();
  }
  return {};
}

StepResult StructureAndMotion::step() {
  work_.keeps = false;
  const bool idle = work_.phase == Phase::idle, recording = work_.phase == Phase::record;
  const Result<bool> picked = idle ? pick() : true;
  const Status status = idle ? picked.status() : advance();
  work_.keeps = work_.keeps && status.ok();
  const bool uncorrected = work_.shutter.id != 0 && work_.shutter.source == MotionSource::none;
  if (status.ok() && recording && uncorrected)
    return {{StatusCode::rates_missing, work_.keyframe.id, work_.shutter.frames}, picked.value()};
  if (status.ok()) return {{}, picked.value(), work_.keeps ? Then::keep : Then::go_on};
  // A permanently damaged record was handled, and is worth an event.
  if (status.is(StatusCode::record_damaged) && work_.phase == Phase::record) return {status, true};
  // The verdict on a keyframe is a failed pose; the verdict on the end of a strip fails its poses that are not final.
  return work_.patience.failed(work_.subject, status);
}

}  // namespace ilp
