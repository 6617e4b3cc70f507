#include "fsw/imaging/overlap_checker.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fsw/base/rng.hpp"
#include "fsw/imaging/apparent_speed.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/work_level.hpp"
#include "fsw/vision/overlap/coarse_search.hpp"
#include "fsw/vision/place/place_overlap.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// A last frame nearer than this to its keyframe adds almost no ground and no baseline.
constexpr double largest_overlap_of_last_keyframe = 0.95;

// The structure goes on where points that two keyframes saw are in the third image: a twelfth of the ground gives some
// 40 of 500 points, and resection needs 15. Two keyframes alone begin a structure if they share a fifth.
constexpr double least_overlap = 0.2;
constexpr double least_shared_by_three = 0.04;

// A camera that climbs sees ground all around that the keyframe does not show, while all of the keyframe stays in view:
// a frame is due as well if so many times more of it is new than the target plans for. In level flight both shares are
// alike within a twentieth.
constexpr double most_unseen_of_planned = 1.5;
// A camera that turns about its subject keeps it in view, and sees it from elsewhere. Over level ground the views of
// frames above the target overlap differ by up to 1.25, with a swinging gondola by up to 1.3.
constexpr double largest_view_turn = 1.5;

// About the rotation of the last frame; between frames a balloon turns and climbs by less.
constexpr double narrow_rotation_rad = 0.2;
constexpr double narrow_scale = 1.12;

OverlapParams overlap_params(const MissionParameters& mission, double predicted_rotation_rad, double predicted_scale) {
  OverlapParams params;
  params.predicted_rotation_rad = predicted_rotation_rad;
  params.max_scale = mission.max_scale;
  // The prediction and the search around it together stay within the range of the search, less a margin for rounding.
  const double most = std::max(1.0, (1 - 1e-9) * coarse_max_scale / params.max_scale);
  params.predicted_scale = std::clamp(predicted_scale, 1 / most, most);
  params.method = mission.overlap_sad ? OverlapMethod::sad : OverlapMethod::ncc;
  // The overlap is measurable somewhat below the bound, so that "too far" and "unknown" are distinct.
  params.min_overlap = mission.min_overlap - 0.05;
  params.max_rotation_rad = mission.max_rotation_rad;
  return params;
}

/// Whether the frame sees the ground of the keyframe from so far elsewhere that the two are hard to match.
bool turned(GrayView image, const OverlapResult& measured) {
  return view_turn_of_plane(image.width, image.height, measured.plane_b_from_a) > largest_view_turn;
}

/// Whether the candidate lies between the views of the keyframe and of such a frame.
bool halves_turn(GrayView image, const OverlapResult& measured, const double (&candidate_from_keyframe)[9]) {
  double keyframe_from_candidate[9], frame_from_candidate[9];
  if (!invert_plane(candidate_from_keyframe, keyframe_from_candidate)) return false;
  compose_planes(measured.plane_b_from_a, keyframe_from_candidate, frame_from_candidate);
  return view_turn_of_plane(image.width, image.height, frame_from_candidate) <= largest_view_turn;
}

/// Whether so much of the frame is new that it is due, although it shows enough of the keyframe.
bool mostly_new(GrayView image, const OverlapResult& measured, double target_overlap) {
  double keyframe_from_frame[9];
  if (!invert_plane(measured.plane_b_from_a, keyframe_from_frame)) return false;
  const double known = footprint_overlap_of_plane(image.width, image.height, keyframe_from_frame);
  return 1 - known >= most_unseen_of_planned * (1 - target_overlap);
}

/// The keyframe of this id, and the one before it in its strip.
Result<bool> find_pair(Reader<KeyframeRecord> store, std::int64_t id, KeyframeRecord& latest, KeyframeRecord& before) {
  ILP_TAKE(const bool known, find(store, id, latest));
  // Those of a strip are numbered without gaps.
  if (!known || latest.index == 0) return false;
  return find(store, latest.id - 1, before);
}

Result<bool> is_of_burst(Reader<CaptureRecord> store, const FrameRecord& frame) {
  if (frame.capture_id == 0) return false;
  CaptureRecord capture;
  ILP_TAKE(const bool asked, find(store, frame.capture_id, capture));
  return asked && capture.source == CaptureSource::burst;
}

void put_measured(const OverlapResult& measured, OverlapRecord& record) {
  record.verdict = measured.verdict;
  record.overlap = measured.overlap;
  record.scale = measured.b_from_a.scale;
  record.rotation_rad = measured.b_from_a.rotation_rad;
  record.shift_x_px = measured.b_from_a.shift_x_px;
  record.shift_y_px = measured.b_from_a.shift_y_px;
  record.ncc = measured.ncc;
  record.ncc_second = measured.ncc_second;
  record.sigma_px = measured.sigma_px;
}

/// Of a rolling shutter: the plane between the keyframe and the frame.
Result<bool> put_plane(Reader<CameraRecord> store, const FrameRecord& frame, std::int64_t keyframe_id,
                       const OverlapResult& measured, FramePlaneRecord& plane) {
  if (measured.verdict != OverlapVerdict::ok) return false;
  CameraRecord camera;
  const Status read = get_camera(store, camera_id, camera);
  if (!read.ok() && !read.is(StatusCode::not_found)) return read;
  plane = {.id = frame.id, .keyframe_id = keyframe_id, .time_ns = frame.time_ns};
  std::memcpy(plane.plane_from_keyframe, measured.plane_b_from_a, sizeof(measured.plane_b_from_a));
  return read.ok() && has_rolling_shutter(camera);
}

/// How far the ground moves in the keyframe's image during its exposure, where that is known.
Status note_blur(Reader<KeyframeRecord, FrameRecord> store, KeyframeRecord& keyframe) {
  FrameRecord frame;
  KeyframeRecord before;
  if (keyframe.index == 0) return {};
  ILP_TAKE(const bool taken, find<FrameRecord>(store, keyframe.frame_id, frame));
  ILP_TAKE(const bool known, find<KeyframeRecord>(store, keyframe.id - 1, before));
  if (!taken || !known || frame.exposure_us <= 0 || keyframe.time_ns <= before.time_ns) return {};
  const Similarity2 moved = similarity_at_centre(frame.width, frame.height, keyframe.plane_from_previous);
  const double speed = apparent_speed_px_s(moved, frame.width, frame.height, keyframe.time_ns - before.time_ns);
  keyframe.blur_px = 1e-6 * static_cast<double>(frame.exposure_us) * speed;
  return {};
}

}  // namespace

constexpr CheckpointForm OverlapChecker::checkpoint = checkpoint_form<State>(component_id);

OverlapChecker::OverlapChecker(Tables store, const MissionParameters& mission, Scratch scratch, Compute* compute)
    : wiring_{store, mission, scratch, compute} {}

Status OverlapChecker::restore() {
  work_ = {.patience = work_.patience};
  if (wiring_.compute != nullptr) workspace_.wide.drop(*wiring_.compute);
  const Status loaded = restore_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  if (!restored(loaded)) return loaded;
  begin_ids<StripRecord>(wiring_.store, state_.last_strip_id);
  begin_ids<KeyframeRecord>(wiring_.store, state_.last_keyframe_id);
  ILP_TRY(resume_after_records());
  return loaded;
}

Status OverlapChecker::resume_after_records() {
  std::int64_t overlap = 0, keyframe = 0;
  ILP_TRY(newest_id<OverlapRecord>(wiring_.store, overlap));
  ILP_TRY(newest_id<KeyframeRecord>(wiring_.store, keyframe));
  StripRecord strip;
  ILP_TAKE(const bool found, found_by(last(wiring_.store, strip)));
  std::int64_t newest_strip = 0;
  ILP_TRY(newest_id<StripRecord>(wiring_.store, newest_strip));
  const bool open = found && strip.end == StripEnd::open;
  const bool is_older = overlap > cursor_.first || keyframe > state_.last_keyframe_id ||
                        newest_strip > state_.last_strip_id || (found && open != (state_.strip_id != 0));
  if (!is_older) return {};
  const Cursor after{std::max(cursor_.first, overlap), cursor_.second};
  State state;
  state.last_strip_id = std::max(state_.last_strip_id, newest_strip);
  state.last_keyframe_id = std::max(state_.last_keyframe_id, keyframe);
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (open) {
    strip.end = StripEnd::overlap_lost;
    ILP_TRY(put(wiring_.store, strip));
  }
  return transaction.commit(after, state, cursor_, state_);
}

Status OverlapChecker::load_keyframe(std::int64_t frame_id) {
  if (work_.loaded_frame_id == frame_id) return {};
  work_.loaded_frame_id = 0;
  ILP_TRY(load_frame_image(wiring_.store, frame_id, workspace_.keyframe_image));
  ILP_TRY(
      prepare_overlap(workspace_.keyframe_image.view(), workspace_.keyframe, wiring_.scratch.as<OverlapWorkspace>()));
  work_.loaded_frame_id = frame_id;
  return {};
}

void OverlapChecker::begin_strip(const FrameRecord& frame, Outcome& outcome) const {
  State& after = outcome.after;
  after.strip_id = ++after.last_strip_id;
  after.motion_known = false;
  after.index = 0;
  select(frame, OverlapResult{}, outcome);
  outcome.strip.first_keyframe_id = outcome.keyframe.id;
}

void OverlapChecker::end_strip(StripEnd reason, Outcome& outcome) const {
  State& after = outcome.after;
  outcome.has_ended = true;
  outcome.ended.id = after.strip_id;
  outcome.ended.end = reason;
  outcome.event = {StatusCode::strip_broken, after.strip_id, static_cast<std::int64_t>(reason)};
  after.strip_id = 0;
  after.keyframe_id = 0;
  after.keyframe_frame_id = 0;
  after.unknown_frame_id = 0;
  after.candidate = {};
}

void OverlapChecker::select(const FrameRecord& frame, const OverlapResult& measured, Outcome& outcome) const {
  State& after = outcome.after;
  KeyframeRecord& keyframe = outcome.keyframe;
  outcome.has_keyframe = true;
  keyframe.id = after.last_keyframe_id + 1;
  keyframe.frame_id = frame.id;
  keyframe.strip_id = after.strip_id;
  keyframe.index = static_cast<std::int32_t>(after.index);
  keyframe.time_ns = frame.time_ns;
  keyframe.altitude = frame.altitude;
  keyframe.overlap = measured.overlap;
  std::memcpy(keyframe.plane_from_previous, measured.plane_b_from_a, sizeof(keyframe.plane_from_previous));

  outcome.strip.id = after.strip_id;
  outcome.strip.last_keyframe_id = keyframe.id;

  after.last_keyframe_id = keyframe.id;
  after.keyframe_id = keyframe.id;
  after.keyframe_frame_id = frame.id;
  after.last_rotation_rad = 0;
  after.last_scale = 1;
  after.unknown_frame_id = 0;
  after.candidate = {};
  ++after.index;
}

Status OverlapChecker::select_candidate(Outcome& outcome) const {
  const Candidate candidate = outcome.after.candidate;
  FrameRecord frame;
  const Status read = get(wiring_.store, candidate.frame_id, frame);
  ILP_TAKE(const bool found, found_by(read));
  if (!found) {
    // It no longer helps: the frame that needed it is examined again without it.
    outcome.after.candidate = {};
    outcome.event = read;
    return {};
  }
  OverlapResult measured;
  measured.overlap = candidate.overlap;
  std::memcpy(measured.plane_b_from_a, candidate.plane_from_keyframe, sizeof(measured.plane_b_from_a));
  select(frame, measured, outcome);
  return {};
}

/// The frame that waits is unlike the keyframe: a strip begins with it. Where it cannot be read, the event says why.
Result<bool> OverlapChecker::begin_strip_of_waiting(Outcome& outcome) const {
  FrameRecord frame;
  const Status read = get(wiring_.store, outcome.after.unknown_frame_id, frame);
  ILP_TAKE(const bool found, found_by(read));
  if (!found) {
    outcome.after.unknown_frame_id = 0;
    outcome.event = read;
    return false;
  }
  end_strip(StripEnd::overlap_unknown, outcome);
  begin_strip(frame, outcome);
  return true;
}

Result<bool> OverlapChecker::handle_command(Outcome& outcome) {
  CommandRecord command;
  ILP_TAKE(const Found found, find_next(wiring_.store, cursor_.second, command));
  if (found == Found::nothing) return false;
  if (found == Found::damaged) {
    // It may have ended the strip, and is not repeated: two strips are better than poses that never become final.
    command.reason = StripEnd::commanded;
  }
  if (command.after_frame_id > cursor_.first) return false;
  const bool ends_strip = command.kind == CommandKind::end_strip && state_.strip_id != 0;
  const Candidate& candidate = state_.candidate;
  const bool last_ground_unseen = candidate.frame_id != 0 && candidate.overlap <= largest_overlap_of_last_keyframe;
  // The command is consumed by the next step, after the last keyframe is stored.
  if (ends_strip && last_ground_unseen && command.reason != StripEnd::pose_lost) {
    ILP_TRY(select_candidate(outcome));
    return true;
  }
  if (ends_strip && state_.unknown_frame_id != 0 && command.reason != StripEnd::pose_lost) {
    // None that follows can tell whether a strip begins with it: its ground is seen for the first time.
    ILP_TRY(begin_strip_of_waiting(outcome).status());
    return true;
  }
  outcome.cursor.second = command.id;
  if (!ends_strip) return true;
  end_strip(command.reason, outcome);
  if (command.reason == StripEnd::end_of_flight) outcome.event = {};
  return true;
}

Status OverlapChecker::correlate(OverlapResult& measured) {
  const OverlapParams wide = overlap_params(wiring_.mission, state_.last_rotation_rad, state_.last_scale);
  if (state_.motion_known) {
    OverlapParams narrow = wide;
    narrow.max_rotation_rad = std::min(wide.max_rotation_rad, narrow_rotation_rad);
    narrow.max_scale = std::min(wide.max_scale, narrow_scale);
    ILP_TRY(measure_overlap(workspace_.keyframe, workspace_.image.view(), narrow,
                            wiring_.scratch.as<OverlapWorkspace>(), measured));
    if (measured.verdict != OverlapVerdict::overlap_unknown) return {};
  }
  return measure_overlap(workspace_.keyframe, workspace_.image.view(), wide, wiring_.scratch.as<OverlapWorkspace>(),
                         measured);
}

Status OverlapChecker::measure(const FrameRecord& frame, OverlapResult& measured) {
  ILP_TRY(load_frame_image(wiring_.store, frame.id, workspace_.image));
  const Status loaded = load_keyframe(state_.keyframe_frame_id);
  work_.keyframe_unreadable = !loaded.ok();
  ILP_TRY(loaded);
  ILP_TRY(correlate(measured));
  const bool weak = measured.verdict == OverlapVerdict::overlap_unknown ||
                    (measured.verdict == OverlapVerdict::ok && measured.ncc < weak_correlation);
  if (!weak || !wiring_.mission.feature_overlap) return {};
  const std::uint64_t seed = mix64(wiring_.mission.seed) ^ static_cast<std::uint64_t>(frame.id);
  OverlapResult by_features;
  ILP_TRY(measure_overlap_by_features(workspace_.keyframe_image.view(), workspace_.image.view(), seed,
                                      wiring_.scratch.as<FeatureOverlapWorkspace>(), by_features));
  if (by_features.verdict == OverlapVerdict::ok) measured = by_features;
  return {};
}

Status OverlapChecker::search_widely(const FrameRecord& frame, Outcome& outcome, OverlapResult& measured) {
  if (!workspace_.wide.at_work(frame.id, state_.keyframe_id)) {
    // With a candidate the strip goes on without it.
    if (!wiring_.mission.wide_search || wiring_.compute == nullptr || state_.candidate.frame_id != 0) return {};
    const Status begun =
        workspace_.wide.begin(frame.id, state_.keyframe_id, workspace_.keyframe, workspace_.image.view(), measured,
                              wiring_.mission.min_overlap - 0.05, wiring_.scratch.as<OverlapWorkspace>());
    // Narrow images have too few pixels at that size.
    if (begun.is(StatusCode::invalid_argument)) return {};
    ILP_TRY(begun);
  }
  ILP_TAKE(const ComputeProgress progress, workspace_.wide.go_on(*wiring_.compute));
  outcome.open = progress != ComputeProgress::done;
  outcome.waits = progress == ComputeProgress::waiting;
  if (outcome.open) return {};
  ILP_TRY(load_frame_image(wiring_.store, frame.id, workspace_.image));
  const Status loaded = load_keyframe(state_.keyframe_frame_id);
  work_.keyframe_unreadable = !loaded.ok();
  ILP_TRY(loaded);
  return workspace_.wide.finish(workspace_.keyframe, workspace_.image.view(), wiring_.scratch.as<OverlapWorkspace>(),
                                measured);
}

Result<bool> OverlapChecker::relocalise(OverlapResult& measured) {
  if (!wiring_.mission.feature_overlap) return false;
  if (measured.verdict != OverlapVerdict::ok) {
    OverlapResult by_places;
    ILP_TRY(measure_overlap_by_places(workspace_.keyframe_image.view(), workspace_.image.view(),
                                      limits::max_place_features, wiring_.scratch.as<PlaceScratch>(), by_places));
    if (by_places.verdict != OverlapVerdict::ok) return false;
    measured = by_places;
  }
  if (measured.overlap < least_overlap) return false;
  KeyframeRecord keyframe;
  ILP_TAKE(const bool found, find(wiring_.store, state_.keyframe_id, keyframe));
  if (!found) return false;
  const GrayView image = workspace_.image.view();
  return keyframe.index == 0 || footprint_shared_by_three(image.width, image.height, keyframe.plane_from_previous,
                                                          measured.plane_b_from_a) >= least_shared_by_three;
}

Result<bool> OverlapChecker::relocalise_across(OverlapResult& measured) {
  KeyframeRecord latest, before;
  ILP_TAKE(const bool found, find_pair(wiring_.store, state_.keyframe_id, latest, before));
  if (!found) return false;
  // Its image takes the place of the latest keyframe's, which is read again for the next frame.
  work_.loaded_frame_id = 0;
  ILP_TAKE(const bool loaded, found_by(load_frame_image(wiring_.store, before.frame_id, workspace_.keyframe_image)));
  if (!loaded) return false;
  OverlapResult across;
  // What only many features find here is so little ground that a strip of its own is worth more.
  ILP_TRY(measure_overlap_by_places(workspace_.keyframe_image.view(), workspace_.image.view(), limits::place_features,
                                    wiring_.scratch.as<PlaceScratch>(), across));
  if (across.verdict != OverlapVerdict::ok || across.overlap < least_overlap) return false;
  const GrayView image = workspace_.image.view();
  const double shared =
      footprint_shared_by_three(image.width, image.height, before.plane_from_previous, across.plane_b_from_a);
  if (before.index > 0 && shared < least_shared_by_three) return false;
  // The record of a keyframe has the plane from the one before it: those who compose the two planes get this one again.
  double before_from_latest[9];
  if (!invert_plane(latest.plane_from_previous, before_from_latest)) return false;
  compose_planes(across.plane_b_from_a, before_from_latest, across.plane_b_from_a);
  across.b_from_a = similarity_at_centre(image.width, image.height, across.plane_b_from_a);
  across.overlap = footprint_overlap_of_plane(image.width, image.height, across.plane_b_from_a);
  // Where the latest keyframe does not reach, it is no bad image: the camera has turned away, and a pose would be weak.
  const bool relocalised = across.overlap >= least_overlap && std::isfinite(across.b_from_a.shift_x_px) &&
                           std::isfinite(across.b_from_a.shift_y_px);
  if (relocalised) measured = across;
  return relocalised;
}

/// Measures the overlap with the latest keyframe. Where nothing relates the frame to it, the next step compares the
/// frame with the keyframe before, because each comparison takes a large part of a step's time.
Result<OverlapChecker::Relation> OverlapChecker::relate(const FrameRecord& frame, Outcome& outcome,
                                                        OverlapResult& measured) {
  if (work_.unrelated_frame_id == frame.id && work_.unrelated_keyframe_id == state_.keyframe_id) {
    measured = work_.unrelated;
    ILP_TRY(load_frame_image(wiring_.store, frame.id, workspace_.image));
    ILP_TAKE(const bool relocalised, relocalise_across(measured));
    return relocalised ? Relation::across_bad : Relation::overlap;
  }
  const bool searching = workspace_.wide.at_work(frame.id, state_.keyframe_id);
  if (!searching) ILP_TRY(measure(frame, measured));
  if (searching || measured.verdict == OverlapVerdict::overlap_unknown) {
    ILP_TRY(search_widely(frame, outcome, measured));
    if (outcome.open) return Relation::overlap;
  }
  const bool too_far = measured.verdict == OverlapVerdict::overlap_unknown ||
                       (measured.verdict == OverlapVerdict::ok && measured.overlap < wiring_.mission.min_overlap);
  if (!too_far || state_.candidate.frame_id != 0) return Relation::overlap;
  ILP_TAKE(const bool relocalised, relocalise(measured));
  const Relation relation = relocalised ? Relation::relocalise : Relation::overlap;
  if (measured.verdict != OverlapVerdict::overlap_unknown || !wiring_.mission.feature_overlap) return relation;
  KeyframeRecord latest, before;
  ILP_TAKE(outcome.open, find_pair(wiring_.store, state_.keyframe_id, latest, before));
  if (!outcome.open) return relation;
  work_.unrelated = measured;
  work_.unrelated_frame_id = frame.id;
  work_.unrelated_keyframe_id = state_.keyframe_id;
  return relation;
}

OverlapChecker::Choice OverlapChecker::classify(const OverlapResult& measured, Relation relation) const {
  const GrayView image = workspace_.image.view();
  const bool measurable = measured.verdict == OverlapVerdict::ok;
  const bool unrelated = measured.verdict == OverlapVerdict::overlap_unknown;
  const bool by_overlap = measurable && relation == Relation::overlap;
  const bool far = by_overlap && measured.overlap < wiring_.mission.min_overlap;
  const bool is_turned = by_overlap && turned(image, measured);
  const double slack = wiring_.mission.capture_mode == CaptureMode::forecast ? wiring_.mission.selection_slack : 0;

  if ((far || unrelated) && state_.candidate.frame_id != 0) return Choice::candidate_first;
  if (far) return Choice::begins_strip;
  if (unrelated) return state_.unknown_frame_id != 0 ? Choice::waiting_begins : Choice::waits;
  if (!measurable) return Choice::rejected;
  if (is_turned && state_.candidate.frame_id != 0 && halves_turn(image, measured, state_.candidate.plane_from_keyframe))
    return Choice::candidate_first;
  // Across a keyframe that nothing relates to the ground ahead, no later frame is compared.
  if (relation == Relation::across_bad || is_turned) return Choice::selected;
  if (measured.overlap <= wiring_.mission.target_overlap + slack ||
      mostly_new(image, measured, wiring_.mission.target_overlap))
    return Choice::selected;
  return Choice::skipped;
}

Status OverlapChecker::apply(Choice choice, const FrameRecord& frame, const OverlapResult& measured,
                             Outcome& outcome) const {
  OverlapRecord& record = outcome.overlap;
  State& after = outcome.after;
  const bool related = choice == Choice::selected || choice == Choice::skipped;
  if (related) {
    after.unknown_frame_id = 0;
    after.last_rotation_rad = measured.b_from_a.rotation_rad;
    after.last_scale = measured.b_from_a.scale;
    after.motion_known = true;
  }
  switch (choice) {
    case Choice::waits:
      after.unknown_frame_id = frame.id;
      [[fallthrough]];
    case Choice::rejected:
      record.decision = OverlapDecision::rejected;
      outcome.event = {StatusCode::overlap_unknown, frame.id, static_cast<std::int64_t>(measured.verdict)};
      return {};
    case Choice::waiting_begins: {
      ILP_TAKE(const bool begun, begin_strip_of_waiting(outcome));
      if (begun) break;
      // This frame waits in its place.
      record.decision = OverlapDecision::rejected;
      after.unknown_frame_id = frame.id;
      return {};
    }
    case Choice::candidate_first:
      ILP_TRY(select_candidate(outcome));
      break;
    case Choice::begins_strip:
      record.decision = OverlapDecision::new_strip;
      end_strip(StripEnd::overlap_lost, outcome);
      begin_strip(frame, outcome);
      return {};
    case Choice::selected:
      record.decision = OverlapDecision::selected;
      select(frame, measured, outcome);
      return {};
    case Choice::skipped:
      record.decision = OverlapDecision::skipped;
      if (state_.candidate.frame_id == 0 || measured.overlap <= state_.candidate.overlap) {
        after.candidate.frame_id = frame.id;
        after.candidate.overlap = measured.overlap;
        std::memcpy(after.candidate.plane_from_keyframe, measured.plane_b_from_a, sizeof(measured.plane_b_from_a));
      }
      return {};
  }
  // The frame is compared again, with another keyframe.
  outcome.has_overlap = false;
  outcome.has_plane = false;
  outcome.cursor = cursor_;
  return {};
}

/// A frame while no strip is open: whether it is good enough for a comparison.
Status OverlapChecker::look_alone(const FrameRecord& frame, Outcome& outcome) {
  OverlapRecord& record = outcome.overlap;
  ILP_TRY(load_frame_image(wiring_.store, frame.id, workspace_.image));
  OverlapResult measured;
  ILP_TRY(measure_overlap(workspace_.image.view(), workspace_.image.view(), overlap_params(wiring_.mission, 0, 1),
                          wiring_.scratch.as<OverlapWorkspace>(), measured));
  // Repeating ground cannot be distinguished from its own copies. Another frame may resolve it.
  record.verdict = measured.verdict == OverlapVerdict::overlap_unknown ? OverlapVerdict::ok : measured.verdict;
  if (record.verdict != OverlapVerdict::ok) {
    record.decision = OverlapDecision::rejected;
    outcome.event = {StatusCode::overlap_unknown, frame.id, static_cast<std::int64_t>(record.verdict)};
    return {};
  }
  record.decision = OverlapDecision::new_strip;
  begin_strip(frame, outcome);
  return {};
}

Status OverlapChecker::evaluate(const FrameRecord& frame, Outcome& outcome) {
  outcome.has_overlap = true;
  OverlapRecord& record = outcome.overlap;
  record.id = frame.id;
  record.keyframe_id = state_.keyframe_id;
  ILP_TAKE(const bool beside, is_of_burst(wiring_.store, frame));
  if (beside) {
    // It shows how the camera moved beside another frame, and decides nothing.
    record.decision = OverlapDecision::burst;
    record.verdict = OverlapVerdict::overlap_unknown;
    if (state_.strip_id == 0) return {};
    OverlapResult measured;
    ILP_TRY(measure(frame, measured));
    put_measured(measured, record);
    ILP_TAKE(outcome.has_plane, put_plane(wiring_.store, frame, state_.keyframe_id, measured, outcome.plane));
    return {};
  }
  if (state_.strip_id == 0) return look_alone(frame, outcome);

  OverlapResult measured;
  ILP_TAKE(const Relation relation, relate(frame, outcome, measured));
  if (outcome.open) return {};
  put_measured(measured, record);
  ILP_TAKE(outcome.has_plane, put_plane(wiring_.store, frame, state_.keyframe_id, measured, outcome.plane));
  return apply(classify(measured, relation), frame, measured, outcome);
}

/// A damaged one is made again from known data: its keyframes are numbered without gaps.
Status OverlapChecker::load_strip(const Outcome& outcome, std::int64_t id, StripRecord& strip) {
  const Status found = get(wiring_.store, id, strip);
  if (!found.is(StatusCode::record_damaged)) return found;
  strip = {};
  strip.id = id;
  const bool of_keyframe = outcome.has_keyframe && outcome.keyframe.strip_id == id;
  strip.last_keyframe_id = of_keyframe ? outcome.keyframe.id : state_.last_keyframe_id;
  const std::int64_t keyframes = of_keyframe ? outcome.keyframe.index + 1 : state_.index;
  strip.first_keyframe_id = strip.last_keyframe_id - keyframes + 1;
  return {};
}

Status OverlapChecker::write(Outcome& outcome) {
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  if (outcome.has_overlap) ILP_TRY(put(wiring_.store, outcome.overlap));
  if (outcome.has_plane) ILP_TRY(put(wiring_.store, outcome.plane));
  if (outcome.has_ended) {
    StripRecord ended;
    ILP_TRY(load_strip(outcome, outcome.ended.id, ended));
    ended.end = outcome.ended.end;
    ILP_TRY(put(wiring_.store, ended));
  }
  if (outcome.has_keyframe) {
    StripRecord strip = outcome.strip;
    if (outcome.keyframe.index > 0) {
      ILP_TRY(load_strip(outcome, strip.id, strip));
      strip.last_keyframe_id = outcome.keyframe.id;
    }
    ILP_TRY(put(wiring_.store, strip));
    KeyframeRecord keyframe = outcome.keyframe;
    ILP_TRY(current_work_level(wiring_.store, keyframe.degraded));
    ILP_TRY(note_blur(wiring_.store, keyframe));
    ILP_TRY(put(wiring_.store, keyframe));
  }
  return transaction.commit(outcome.cursor, outcome.after, cursor_, state_);
}

/// The decision on the frame, or on the strip if its keyframe cannot be read.
StepResult OverlapChecker::choose(const Status& found, const FrameRecord& frame, Outcome& outcome) {
  outcome.cursor.first = frame.id;
  work_.keyframe_unreadable = false;
  Status status = found.ok() ? evaluate(frame, outcome) : found;
  if (status.ok()) return {{}, true, outcome.waits ? Then::wait : Then::go_on};
  if (is_transient(status) && !work_.patience.abandoned(frame.id)) return work_.patience.failed(frame.id, status);
  outcome = {.after = state_, .cursor = cursor_};
  if (work_.keyframe_unreadable) {
    // Nothing can be compared with it any more, so the frame is examined alone.
    end_strip(StripEnd::overlap_lost, outcome);
    return {{}, true};
  }
  // A frame that cannot be read is passed over; the cursor moves on so that it is not tried for ever.
  outcome.cursor.first = frame.id;
  outcome.has_overlap = true;
  outcome.overlap.id = frame.id;
  outcome.overlap.verdict = OverlapVerdict::overlap_unknown;
  outcome.overlap.decision = OverlapDecision::rejected;
  outcome.event = work_.patience.abandoned(frame.id) ? Status{} : status;
  return {{}, true};
}

StepResult OverlapChecker::step() {
  Outcome outcome{.after = state_, .cursor = cursor_};

  const Result<bool> handled = handle_command(outcome);
  if (!handled.ok()) return {handled.status(), false};
  if (!handled.value()) {
    FrameRecord frame;
    const Status read = next(wiring_.store, cursor_.first, frame);
    if (read.is(StatusCode::not_found)) return {};
    if (!read.ok() && !read.is(StatusCode::record_damaged)) return {read, false};
    if (!read.ok()) frame.id = read.a;
    const StepResult chosen = choose(read, frame, outcome);
    if (!chosen.status.ok() || outcome.open) return chosen;
  }
  const Status written = write(outcome);
  if (!written.ok()) return {written, true};
  return {outcome.event, true};
}

}  // namespace ilp
