#include "fsw/terrain/dense_matcher.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fsw/base/status_values.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/frame_access.hpp"
#include "fsw/shared/work_level.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/rectify/rectification_axes.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

constexpr std::int32_t band_rows = 16;
// Ground between the structure's points may be nearer or farther than any of them.
constexpr double depth_margin = 1.15;
// A pair with a smaller matched share of its image gives no information about the terrain.
constexpr double smallest_matched_share = 0.01;
// Of the 64 pixels of a cell.
constexpr std::int32_t smallest_cell = 32;

template <typename T>
std::span<const std::uint8_t> bytes_of(ImageView<const T> view) {
  return {reinterpret_cast<const std::uint8_t*>(view.data), view.area() * sizeof(T)};
}

double distance(const PoseRecord& a, const PoseRecord& b) {
  double sum = 0;
  for (int i = 0; i < 3; ++i) sum += (a.centre[i] - b.centre[i]) * (a.centre[i] - b.centre[i]);
  return std::sqrt(sum);
}

Status use_coverage_of(std::int64_t keyframe_id, const CameraModel& camera, DenseMatcher::State& carried) {
  if (carried.coverage_keyframe_id == keyframe_id) return {};
  carried.coverage_keyframe_id = keyframe_id;
  return clear_coverage(camera.width, camera.height, carried.coverage);
}

Status clear(const CameraModel& camera, DenseMatcher::DepthMaps& depth) {
  for (auto* map : {&depth.inverse, &depth.sigma}) {
    ILP_TRY(map->resize(camera.width, camera.height));
    std::fill_n(map->view().data, map->view().area(), 0.0F);
  }
  ILP_TRY(depth.supported.resize(supported_words(camera.width), camera.height));
  std::fill_n(depth.supported.view().data, depth.supported.view().area(), std::uint64_t{0});
  return {};
}

void state_geometry(const DenseMatcher::Work& work, DenseMatcher::Workspace& w, DepthRecord& record) {
  const RigidTransform partner_from_this =
      compose(cam_from_world(pose_of(work.partner.pose)), inverse(cam_from_world(pose_of(work.pose))));
  Vec2 epipole;
  if (work.plan.blind_radius_px > 0 && epipole_of(work.camera, partner_from_this, epipole)) {
    record.epipole_x = epipole.x();
    record.epipole_y = epipole.y();
    record.blind_radius_px = work.plan.blind_radius_px;
  }
  const ImageView<const float> inverse_depth = std::as_const(w.maps.inverse).view();
  const double by_poses = median_depth_error_of_poses(partner_from_this, work.partner.step, work.camera, inverse_depth,
                                                      w.shared.record.pose_errors);
  const double by_lens = work.partner.pose.lens_depth_sigma;
  record.pose_sigma = by_lens > 0 && by_poses > 0 ? std::sqrt(by_poses * by_poses + by_lens * by_lens) : by_poses;
}

void state_median_sigma(ImageView<const std::uint8_t> sigma_codes, DepthRecord& record) {
  std::array<std::uint32_t, sigma_code_largest + 1> histogram{};
  for (std::size_t i = 0; i < sigma_codes.area(); ++i) ++histogram[sigma_codes.data[i] & sigma_code_largest];
  std::uint32_t below = 0;
  std::size_t median = 1;
  for (; median < sigma_code_largest && 2 * (below + histogram[median]) < record.valid; ++median)
    below += histogram[median];
  record.median_sigma_px = static_cast<double>(median) / sigma_codes_per_px;
  record.values.bytes = static_cast<std::uint32_t>(2 * sigma_codes.area());
  record.sigma.bytes = static_cast<std::uint32_t>(sigma_codes.area());
}

/// Of cells with a few pixels of depth nobody can say later which part was seen.
Status describe_cells(DenseMatcher::Workspace& w, DepthRecord& record) {
  ILP_TRY(cell_depths(w.maps.inverse.view(), w.maps.sigma.view(), smallest_cell, w.cell_depths));
  const auto cells = static_cast<std::size_t>(w.now.columns) * static_cast<std::size_t>(w.now.rows);
  for (std::size_t i = 0; i < cells; ++i) {
    if (!(w.cell_depths[i] > 0)) w.now.quality[i] = 0;
  }
  record.cells.bytes = static_cast<std::uint32_t>(cells * (1 + sizeof(float)));
  return {};
}

Status plane_between(Reader<KeyframeRecord> store, std::int64_t from_keyframe_id, std::int64_t to_keyframe_id,
                     Mat3& to_from_from) {
  to_from_from = Mat3::Identity();
  for (std::int64_t id = from_keyframe_id + 1; id <= to_keyframe_id; ++id) {
    KeyframeRecord keyframe;
    ILP_TRY(get(store, id, keyframe));
    Mat3 plane;
    for (int i = 0; i < 9; ++i) plane(i / 3, i % 3) = keyframe.plane_from_previous[i];
    to_from_from = plane * to_from_from;
  }
  return {};
}

/// A strip is abandoned after two failures in a row, so that a pair reaches across one keyframe at most.
Status cover_passed(Reader<KeyframeRecord> store, const CameraModel& camera, std::int64_t first_id,
                    std::int64_t second_id, ImageView<const float> sigma, DenseMatcher::State& carried) {
  carried.passed_keyframe_id = 0;
  if (second_id != first_id + 2) return {};
  const std::int64_t passed_id = first_id + 1;
  Mat3 passed_from_first;
  Mat3 second_from_passed;
  ILP_TRY(plane_between(store, first_id, passed_id, passed_from_first));
  ILP_TRY(plane_between(store, passed_id, second_id, second_from_passed));
  ILP_TRY(clear_coverage(camera.width, camera.height, carried.passed));
  // The mask of an image without a pose depends on what is covered, not on how well that was seen.
  constexpr std::uint8_t covered = 1;
  const auto known = [&](std::int32_t x, std::int32_t y) {
    // Without depth the image of the first is sent whole.
    const bool sent = sigma.empty() || sigma.at(x, y) > 0 || carried.coverage.at(x, y);
    return sent ? covered : std::uint8_t{0};
  };
  cover_over_plane(passed_from_first.inverse(), known, carried.passed);
  cover_over_plane(
      second_from_passed, [](std::int32_t, std::int32_t) { return covered; }, carried.passed);
  carried.passed_keyframe_id = passed_id;
  return {};
}

/// Carries the ground that earlier pairs have reconstructed to the next keyframe with a pose; 0 when there is none.
Result<std::int64_t> carry_without_depth(Reader<PoseRecord, StripRecord, KeyframeRecord> store,
                                         const CameraModel& camera, const PoseRecord& pose,
                                         DenseMatcher::State& carried, Coverage& before) {
  if (pose.state == PoseState::failed) return std::int64_t{0};
  PoseRecord next;
  ILP_TAKE(const Successor state, next_with_pose(store, pose, pose.id, next));
  if (state != Successor::final) return std::int64_t{0};
  ILP_TRY(cover_passed(store, camera, pose.id, next.id, {}, carried));
  Mat3 next_from_this;
  ILP_TRY(plane_between(store, pose.id, next.id, next_from_this));
  before = carried.coverage;
  ILP_TRY(clear_coverage(camera.width, camera.height, carried.coverage));
  const auto known = [&before](std::int32_t x, std::int32_t y) {
    return before.at(x, y) ? before.seen.at(x, y) : std::uint8_t{0};
  };
  cover_over_plane(next_from_this.inverse(), known, carried.coverage);
  return next.id;
}

Status code_mask(DenseMatcher::RecordWorkspace& w, MaskRecord& mask) {
  std::size_t size = 0;
  ILP_TRY(encode_mask(w.mask.view(), w.mask_bytes.data(), w.mask_bytes.size(), size));
  mask.code.bytes = static_cast<std::uint32_t>(size);
  return {};
}

}  // namespace

constexpr CheckpointForm DenseMatcher::checkpoint = checkpoint_form<State>(component_id);

DenseMatcher::DenseMatcher(Tables store, const MissionParameters& mission) : wiring_{store, mission} {}

Status DenseMatcher::restore() {
  cursor_ = {};
  work_.phase = Phase::idle;
  ILP_TRY(load_camera(wiring_.store, work_.camera));
  const Status status = load_checkpoint(wiring_.store, checkpoint, cursor_, state_);
  const bool none = status.is(StatusCode::not_found) || status.is(StatusCode::checkpoint_lost);
  if (!none && !restored(status)) return status;
  if (none) cursor_ = {};
  std::int64_t newest = 0;
  ILP_TRY(newest_id<DepthRecord>(wiring_.store, newest));
  if (none || newest > cursor_.first) {
    // Other components have used the records: they are not made again, although their coverage is lost.
    cursor_.first = std::max(cursor_.first, newest);
    state_.coverage_keyframe_id = 0;
    state_.passed_keyframe_id = 0;
  }
  return status.is(StatusCode::not_found) ? Status{} : status;
}

Result<Successor> DenseMatcher::find_partner() {
  if (work_.pose.state == PoseState::failed) return Successor::none;
  ILP_TAKE(const Successor next, next_with_pose(wiring_.store, work_.pose, work_.pose.id, work_.next));
  if (next != Successor::final) return next;
  workspace_.after = state_;
  ILP_TRY(use_coverage_of(work_.pose.id, work_.camera, workspace_.after));
  PairUtilityParams params;
  params.largest_sigma = wiring_.mission.largest_depth_sigma;
  params.finer_steps = sampling_steps(wiring_.mission.claim_ratio);
  return choose_partner(wiring_.store, work_.camera, work_.pose, work_.next, workspace_.after.coverage, params,
                        wiring_.mission.partner_reach, work_.partner);
}

Result<DepthVerdict> DenseMatcher::begin_pair() {
  const PoseRecord& partner = work_.partner.pose;
  const DepthRange depth{work_.pose.min_depth / depth_margin, work_.pose.max_depth * depth_margin};
  KeyframeRecord keyframe;
  ILP_TRY(get(wiring_.store, work_.pose.id, keyframe));
  RectificationParams params;
  params.scale = stereo_scale_at(keyframe.degraded);
  const Status planned = plan_panels(work_.camera, cam_from_world(pose_of(work_.pose)),
                                     cam_from_world(pose_of(partner)), depth, params, work_.plan);
  const bool cut = planned.is(StatusCode::disparity_range_exceeded);
  if (!planned.ok() && !cut) return DepthVerdict::rectification_impossible;
  ILP_TRY(load_keyframe_image(wiring_.store, work_.pose.id, workspace_.left));
  ILP_TRY(load_keyframe_image(wiring_.store, partner.id, workspace_.right));
  work_.panel = 0;
  work_.residual = {};
  ILP_TRY(begin_panel());
  // The near end of the range was cut: the pair continues.
  work_.event = planned;
  return DepthVerdict::ok;
}

Status DenseMatcher::begin_panel() {
  const RectifiedPair& pair = work_.at_panel().pair;
  for (auto* image :
       {&workspace_.rectified_left, &workspace_.rectified_right, &workspace_.valid_left, &workspace_.valid_right}) {
    ILP_TRY(image->resize(pair.width, pair.height));
  }
  ILP_TRY(workspace_.disparity.resize(pair.width, pair.height));
  ILP_TRY(workspace_.disparity_sigma.resize(pair.width, pair.height));
  work_.row = 0;
  work_.phase = Phase::resample;
  return {};
}

Result<bool> DenseMatcher::pick() {
  const std::int64_t id = cursor_.first + 1;
  if (work_.patience.abandoned(id)) {
    ILP_TRY(record_abandoned());
    return true;
  }
  const Status found = get(wiring_.store, id, work_.pose);
  if (found.is(StatusCode::not_found) || (found.ok() && is_open(work_.pose.state))) return false;
  ILP_TRY(found);
  // It may have been calibrated since.
  ILP_TRY(load_camera(wiring_.store, work_.camera));
  ILP_TAKE(const Successor partner, find_partner());
  if (partner == Successor::none) ILP_TRY(record_without_depth(work_.pose, DepthVerdict::no_partner));
  if (partner == Successor::final) work_.phase = Phase::begin;
  return partner != Successor::not_yet;
}

Status DenseMatcher::resample_band() {
  const RectifiedPair& pair = work_.at_panel().pair;
  const std::int32_t end = std::min(work_.row + band_rows, pair.height);
  ILP_TRY(resample_rows(pair, Side::left, work_.camera, workspace_.left.view(), work_.row, end,
                        workspace_.rectified_left.view(), workspace_.valid_left.view()));
  ILP_TRY(resample_rows(pair, Side::right, work_.camera, workspace_.right.view(), work_.row, end,
                        workspace_.rectified_right.view(), workspace_.valid_right.view()));
  work_.row = end;
  if (work_.row < pair.height) return {};
  StereoParams params;
  params.matcher = wiring_.mission.matcher;
  params.min_ncc = wiring_.mission.min_correlation;
  work_.phase = Phase::match;
  ILP_TRY(workspace_.matcher.begin(workspace_.rectified_left.view(), workspace_.rectified_right.view(),
                                   workspace_.valid_left.view(), workspace_.valid_right.view(), work_.at_panel().range,
                                   params, workspace_.shared.stereo,
                                   {workspace_.disparity.view(), workspace_.disparity_sigma.view()}));
  return {};
}

Status DenseMatcher::match_band() {
  ILP_TAKE(const bool more, workspace_.matcher.step(band_rows));
  if (!more) work_.phase = Phase::residuals;
  return {};
}

Status DenseMatcher::check_rows() {
  add_vertical_residuals(workspace_.rectified_left.view(), workspace_.rectified_right.view(),
                         workspace_.valid_right.view(), workspace_.matcher.result(), work_.residual);
  work_.phase = Phase::depth;
  work_.row = 0;
  return {};
}

Status DenseMatcher::depth_band() {
  if (work_.panel == 0 && work_.row == 0) ILP_TRY(clear(work_.camera, workspace_.maps));
  const std::int32_t end = std::min(work_.row + 4 * band_rows, work_.camera.height);
  ILP_TRY(depth_rows(work_.at_panel().pair, work_.camera, workspace_.matcher.result(), work_.row, end,
                     workspace_.maps.view()));
  work_.row = end;
  if (work_.row < work_.camera.height) return {};
  if (++work_.panel < work_.plan.count) return begin_panel();
  work_.phase = Phase::errors;
  return {};
}

Status DenseMatcher::state_errors() {
  if (work_.residual.count >= min_vertical_residuals && work_.residual.median_px() > max_vertical_residual_px) {
    return abandon_partner(DepthVerdict::rectification_impossible,
                           {StatusCode::rectification_impossible, work_.pose.id,
                            static_cast<std::int64_t>(RectificationFault::poses_contradict)});
  }
  work_.record = {};
  work_.mask = {};
  work_.record.id = work_.pose.id;
  work_.record.strip_id = work_.pose.strip_id;
  work_.record.partner_id = work_.partner.pose.id;
  work_.record.baseline = distance(work_.pose, work_.partner.pose);
  work_.record.disparity_per_inverse_depth_px = work_.plan.disparity_per_inverse_depth_px;
  drop_uncertain_depths(wiring_.mission.largest_depth_sigma, workspace_.maps.view());
  state_geometry(work_, workspace_, work_.record);
  work_.phase = Phase::quality;
  return {};
}

Status DenseMatcher::state_quality() {
  RecordWorkspace& w = workspace_.shared.record;
  ILP_TRY(w.sigma_code.resize(work_.camera.width, work_.camera.height));
  work_.record.supported =
      code_sigma(workspace_.maps.view(), work_.record.disparity_per_inverse_depth_px, w.sigma_code.view().data);
  work_.phase = Phase::mask;
  return seen_cells(workspace_.maps.inverse.view(), workspace_.maps.sigma.view(), work_.camera.fx, 1, workspace_.now);
}

/// The mask of the ground that is new.
Status DenseMatcher::claim_ground() {
  RecordWorkspace& w = workspace_.shared.record;
  workspace_.after = state_;
  ILP_TRY(use_coverage_of(work_.pose.id, work_.camera, workspace_.after));
  ILP_TRY(w.mask.resize(work_.camera.width, work_.camera.height));
  ILP_TRY(w.codes.resize(work_.camera.width, work_.camera.height));
  MaskCounts counts;
  ILP_TRY(newly_seen_mask(workspace_.maps.sigma.view(), workspace_.after.coverage, workspace_.now,
                          work_.partner.finer_steps, w.mask.view(), counts));
  const auto area = static_cast<double>(w.mask.view().area());
  if (counts.matched < smallest_matched_share * area) {
    return abandon_partner(DepthVerdict::too_few_valid, {});
  }
  work_.record.valid = counts.matched;
  work_.mask.newly_seen = counts.newly_seen;
  work_.phase = Phase::coding;
  return {};
}

Status DenseMatcher::choose_coding() {
  const RecordWorkspace& w = workspace_.shared.record;
  DepthCoding coding;
  ILP_TRY(choose_depth_coding(workspace_.maps.inverse.view(), workspace_.maps.sigma.view(), w.mask.view(),
                              work_.plan.disparity_per_inverse_depth_px / work_.plan.baseline, work_.plan.baseline,
                              1.0 / wiring_.mission.depth_step_px, coding));
  work_.record.offset = coding.offset;
  work_.record.step = coding.step;
  work_.phase = Phase::codes;
  return {};
}

Status DenseMatcher::code_depth() {
  RecordWorkspace& w = workspace_.shared.record;
  ILP_TRY(encode_depth(workspace_.maps.inverse.view(), workspace_.maps.sigma.view(), w.mask.view(),
                       {work_.record.offset, work_.record.step}, w.codes.view()));
  state_median_sigma(w.sigma_code.view(), work_.record);
  work_.phase = Phase::mask_code;
  return {};
}

Status DenseMatcher::begin_carry() {
  workspace_.after = state_;
  ILP_TRY(use_coverage_of(work_.pose.id, work_.camera, workspace_.after));
  ILP_TRY(cover_passed(wiring_.store, work_.camera, work_.pose.id, work_.next.id, workspace_.maps.sigma.view(),
                       workspace_.after));
  work_.phase = Phase::coverage;
  return begin_carrying(work_.camera, workspace_.ground(), workspace_.shared.record.coverage,
                        workspace_.after.coverage);
}

Status DenseMatcher::carry_ground() {
  const RigidTransform next_from_this =
      compose(cam_from_world(pose_of(work_.next)), inverse(cam_from_world(pose_of(work_.pose))));
  ILP_TAKE(const bool more, carry_coverage_slice(work_.camera, workspace_.ground(), next_from_this,
                                                 workspace_.shared.record.coverage, workspace_.after.coverage));
  if (!more) work_.phase = Phase::cells;
  return {};
}

/// The pair has given no depth: what is `reported` counts if the partner is the next keyframe, which is tried
/// otherwise.
Status DenseMatcher::abandon_partner(DepthVerdict verdict, Status reported) {
  if (work_.partner.pose.id != work_.next.id) {
    work_.partner = partner_of(work_.next, sampling_steps(wiring_.mission.claim_ratio));
    ILP_TAKE(verdict, begin_pair());
    if (verdict == DepthVerdict::ok) return {};
    reported = {};
  }
  ILP_TRY(record_without_depth(work_.pose, verdict));
  work_.event = reported;
  return {};
}

Status DenseMatcher::record_without_depth(const PoseRecord& pose, DepthVerdict verdict) {
  DepthRecord record;
  MaskRecord new_ground;
  record.id = pose.id;
  record.strip_id = pose.strip_id;
  record.verdict = verdict;
  workspace_.after = state_;
  const bool passed = pose.id == workspace_.after.passed_keyframe_id;
  if (!passed) ILP_TRY(use_coverage_of(work_.pose.id, work_.camera, workspace_.after));
  const Coverage& coverage = passed ? workspace_.after.passed : workspace_.after.coverage;
  ILP_TRY(workspace_.shared.record.mask.resize(work_.camera.width, work_.camera.height));
  const ImageView<std::uint8_t> mask = workspace_.shared.record.mask.view();
  for (std::size_t i = 0; i < mask.area(); ++i) {
    const bool covered = coverage.at(i);
    mask.data[i] = covered ? 0 : 255;
    new_ground.newly_seen += covered ? 0 : 1;
  }
  ILP_TAKE(const std::int64_t next_id,
           passed ? workspace_.after.coverage_keyframe_id
                  : carry_without_depth(wiring_.store, work_.camera, pose, workspace_.after, workspace_.before));
  ILP_TRY(code_mask(workspace_.shared.record, new_ground));
  return write(record, new_ground, next_id);
}

/// A part of the pair, or of its coverage, cannot be read: the image of the keyframe is sent whole.
Status DenseMatcher::record_abandoned() {
  const std::int64_t id = cursor_.first + 1;
  PoseRecord pose;
  ILP_TAKE(const bool posed, find<PoseRecord>(wiring_.store, id, pose));
  if (posed) {
    ILP_TAKE(const bool recorded, found_by(record_without_depth(pose, DepthVerdict::too_few_valid)));
    if (recorded) return {};
  }
  KeyframeRecord keyframe;
  ILP_TAKE(const bool known, find<KeyframeRecord>(wiring_.store, id, keyframe));
  DepthRecord record;
  MaskRecord new_ground;
  record.id = id;
  record.strip_id = known ? keyframe.strip_id : 0;
  record.verdict = DepthVerdict::too_few_valid;
  ILP_TRY(workspace_.shared.record.mask.resize(work_.camera.width, work_.camera.height));
  const ImageView<std::uint8_t> mask = workspace_.shared.record.mask.view();
  std::fill_n(mask.data, mask.area(), std::uint8_t{255});
  new_ground.newly_seen = static_cast<std::uint32_t>(mask.area());
  workspace_.after = state_;
  workspace_.after.passed_keyframe_id = 0;
  ILP_TRY(code_mask(workspace_.shared.record, new_ground));
  return write(record, new_ground, 0);
}

Status DenseMatcher::write(DepthRecord& record, MaskRecord& mask, std::int64_t next_coverage_id) {
  RecordWorkspace& w = workspace_.shared.record;
  mask.id = record.id;
  mask.width = record.width = work_.camera.width;
  mask.height = record.height = work_.camera.height;
  workspace_.after.coverage_keyframe_id = next_coverage_id;

  work_.patience.begin_writing();
  StepTransaction transaction(wiring_.store, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(wiring_.store, record));
  if (record.values.bytes != 0) {
    const ImageView<const std::uint16_t> codes = w.codes.view();
    const ImageView<const std::uint8_t> sigma = w.sigma_code.view();
    ILP_TRY(write_blob<DepthRecord>(wiring_.store, "values", record.id, 0, bytes_of(codes)));
    ILP_TRY(write_blob<DepthRecord>(wiring_.store, "sigma", record.id, 0, bytes_of(sigma)));
    const std::size_t cells = record.cells.bytes / (1 + sizeof(float));
    const std::span<const std::uint8_t> quality(workspace_.now.quality.data(), cells);
    const ImageView<const float> depths(workspace_.cell_depths.data(), static_cast<std::int32_t>(cells), 1);
    ILP_TRY(write_blob<DepthRecord>(wiring_.store, "cells", record.id, 0, quality));
    ILP_TRY(write_blob<DepthRecord>(wiring_.store, "cells", record.id, cells, bytes_of(depths)));
  }
  ILP_TRY(put(wiring_.store, mask));
  ILP_TRY(write_blob<MaskRecord>(wiring_.store, "code", mask.id, 0, {w.mask_bytes.data(), mask.code.bytes}));
  ILP_TRY(transaction.commit(Cursor{record.id, cursor_.second}, workspace_.after, cursor_, state_));
  work_.patience.end_writing();
  work_.phase = Phase::idle;
  return {};
}

Status DenseMatcher::advance() {
  switch (work_.phase) {
    case Phase::idle:
      break;
    case Phase::begin: {
      ILP_TAKE(const DepthVerdict verdict, begin_pair());
      return verdict == DepthVerdict::ok ? Status{} : abandon_partner(verdict, {});
    }
    case Phase::resample:
      return resample_band();
    case Phase::match:
      return match_band();
    case Phase::residuals:
      return check_rows();
    case Phase::depth:
      return depth_band();
    case Phase::errors:
      return state_errors();
    case Phase::quality:
      return state_quality();
    case Phase::mask:
      return claim_ground();
    case Phase::coding:
      return choose_coding();
    case Phase::codes:
      return code_depth();
    case Phase::mask_code:
      work_.phase = Phase::passed;
      return code_mask(workspace_.shared.record, work_.mask);
    case Phase::passed:
      return begin_carry();
    case Phase::coverage:
      return carry_ground();
    case Phase::cells:
      work_.phase = Phase::record;
      return describe_cells(workspace_, work_.record);
    case Phase::record:
      return write(work_.record, work_.mask, work_.next.id);
  }
  return {};
}

StepResult DenseMatcher::step() {
  if (wiring_.mission.safe_mode) return {};
  work_.event = {};
  const bool idle = work_.phase == Phase::idle;
  const Result<bool> picked = idle ? pick() : true;
  const Status status = idle ? picked.status() : advance();
  if (!status.ok()) return work_.patience.failed(cursor_.first + 1, status);
  return {work_.event, picked.value(), Then::go_on};
}

}  // namespace ilp
