#include "fsw/terrain/dense_matcher.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/status_values.hpp"
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

}  // namespace

constexpr CheckpointForm DenseMatcher::checkpoint = checkpoint_form<State>(component_id);

DenseMatcher::DenseMatcher(Tables store, const MissionParameters& mission) : store_(store), mission_(mission) {}

void DenseMatcher::match_on(Compute& compute, StereoBandWorkspace& workspace) {
  StereoMatcher::lend(work_.stereo, workspace);
  bands_.use(compute, workspace);
}

Status DenseMatcher::restore() {
  cursor_ = {};
  phase_ = Phase::idle;
  ILP_TRY(load_camera(store_, camera_));
  const Status status = load_checkpoint(store_, checkpoint, cursor_, state_);
  const bool none = status.is(StatusCode::not_found) || status.is(StatusCode::checkpoint_lost);
  if (!none && !restored(status)) return status;
  if (none) cursor_ = {};
  std::int64_t newest = 0;
  ILP_TRY(newest_id<DepthRecord>(store_, newest));
  if (none || newest > cursor_.first) {
    // Other components have used the records: they are not made again, although their coverage is lost.
    cursor_.first = std::max(cursor_.first, newest);
    state_.coverage_keyframe_id = 0;
    state_.passed_keyframe_id = 0;
  }
  return status.is(StatusCode::not_found) ? Status{} : status;
}

Status DenseMatcher::use_coverage_of(std::int64_t keyframe_id) {
  if (after_.coverage_keyframe_id == keyframe_id) return {};
  after_.coverage_keyframe_id = keyframe_id;
  return clear_coverage(camera_.width, camera_.height, after_.coverage);
}

Status DenseMatcher::find_partner(const PoseRecord& pose, Successor& state) {
  state = Successor::none;
  if (pose.state == PoseState::failed) return {};
  ILP_TRY(next_with_pose(store_, pose, pose.id, next_, state));
  if (state != Successor::final) return {};
  after_ = state_;
  ILP_TRY(use_coverage_of(pose.id));
  PairWorthParams params;
  params.largest_sigma = mission_.largest_depth_sigma;
  params.finer_steps = sampling_steps(mission_.claim_ratio);
  return choose_partner(store_, camera_, pose, next_, after_.coverage, params, mission_.partner_reach, partner_, state);
}

Status DenseMatcher::begin_with_partner(const PoseRecord& pose, DepthVerdict& verdict) {
  const Status begun = begin_pair(pose, verdict);
  if (verdict == DepthVerdict::ok || partner_.pose.id == next_.id) return begun;
  partner_ = partner_of(next_, sampling_steps(mission_.claim_ratio));
  return begin_pair(pose, verdict);
}

Status DenseMatcher::begin_pair(const PoseRecord& pose, DepthVerdict& verdict) {
  const PoseRecord& partner = partner_.pose;
  const DepthRange depth{pose.min_depth / depth_margin, pose.max_depth * depth_margin};
  KeyframeRecord keyframe;
  ILP_TRY(get(store_, pose.id, keyframe));
  RectificationParams params;
  params.scale = stereo_scale_at(keyframe.degraded);
  verdict = DepthVerdict::rectification_impossible;
  const Status planned =
      plan_panels(camera_, cam_from_world(pose_of(pose)), cam_from_world(pose_of(partner)), depth, params, plan_);
  if (planned.is(StatusCode::rectification_impossible) || planned.is(StatusCode::invalid_argument)) return {};
  if (!planned.ok() && !planned.is(StatusCode::disparity_range_exceeded)) return planned;
  verdict = DepthVerdict::ok;

  ILP_TRY(load_keyframe_image(store_, pose.id, left_));
  ILP_TRY(load_keyframe_image(store_, partner.id, right_));
  pose_ = pose;
  panel_ = 0;
  residual_ = {};
  ILP_TRY(begin_panel());
  // The near end of the range was cut. This is worth an event, and the pair continues.
  return planned;
}

Status DenseMatcher::begin_panel() {
  const RectifiedPair& pair = panel().pair;
  for (auto* image : {&rectified_left_, &rectified_right_, &valid_left_, &valid_right_}) {
    ILP_TRY(image->resize(pair.width, pair.height));
  }
  ILP_TRY(disparity_.resize(pair.width, pair.height));
  ILP_TRY(disparity_sigma_.resize(pair.width, pair.height));
  row_ = 0;
  phase_ = Phase::resample;
  return {};
}

Status DenseMatcher::pick(bool& picked) {
  picked = false;
  const std::int64_t id = cursor_.first + 1;
  if (patience_.given_up(id)) {
    picked = true;
    return record_given_up();
  }
  PoseRecord pose;
  const Status found = get(store_, id, pose);
  if (found.is(StatusCode::not_found) || (found.ok() && pose.state == PoseState::provisional)) return {};
  ILP_TRY(found);
  // It may have been calibrated since.
  ILP_TRY(load_camera(store_, camera_));
  Successor partner = Successor::none;
  ILP_TRY(find_partner(pose, partner));
  if (partner == Successor::not_yet) return {};
  picked = true;
  if (partner == Successor::none) return record_without_depth(pose, DepthVerdict::no_partner);
  pose_ = pose;
  phase_ = Phase::begin;
  return {};
}

Status DenseMatcher::begin() {
  DepthVerdict verdict = DepthVerdict::ok;
  const Status warning = begin_with_partner(pose_, verdict);
  if (!warning.ok() && !warning.is(StatusCode::disparity_range_exceeded)) return warning;
  if (verdict != DepthVerdict::ok) return record_without_depth(pose_, verdict);
  return warning;
}

Status DenseMatcher::resample_band() {
  const RectifiedPair& pair = panel().pair;
  const std::int32_t end = std::min(row_ + band_rows, pair.height);
  ILP_TRY(
      resample_rows(pair, Side::left, camera_, left_.view(), row_, end, rectified_left_.view(), valid_left_.view()));
  ILP_TRY(resample_rows(pair, Side::right, camera_, right_.view(), row_, end, rectified_right_.view(),
                        valid_right_.view()));
  row_ = end;
  if (row_ < pair.height) return {};
  StereoParams params;
  params.matcher = mission_.matcher;
  params.min_ncc = mission_.min_correlation;
  phase_ = Phase::match;
  rows_matched_ = 0;
  ILP_TRY(matcher_.begin(rectified_left_.view(), rectified_right_.view(), valid_left_.view(), valid_right_.view(),
                         panel().range, params, work_.stereo, {disparity_.view(), disparity_sigma_.view()}));
  // Later panels add to the maps, where jobs would lie.
  if (panel_ == 0) bands_.begin(work_.stereo, maps_.band, matcher_);
  return {};
}

Status DenseMatcher::match_band(bool& waits) {
  bool more = true;
  for (; more && rows_matched_ < band_rows; ++rows_matched_) {
    ComputeProgress band = ComputeProgress::done;
    if (matcher_.wants_band()) ILP_TRY(bands_.get(matcher_, maps_.band, band));
    waits = band == ComputeProgress::waiting;
    if (band != ComputeProgress::done) return {};
    ILP_TRY(matcher_.step(1, more));
  }
  rows_matched_ = 0;
  if (!more) phase_ = Phase::residuals;
  return {};
}

Status DenseMatcher::check_rows() {
  add_vertical_residuals(rectified_left_.view(), rectified_right_.view(), valid_right_.view(), matcher_.result(),
                         residual_);
  phase_ = Phase::depth;
  row_ = 0;
  return {};
}

Status DenseMatcher::begin_depth() {
  for (ImageBuffer<float>* map : {&maps_.depth.inverse, &maps_.depth.sigma}) {
    ILP_TRY(map->resize(camera_.width, camera_.height));
    std::fill_n(map->view().data, map->view().area(), 0.0F);
  }
  ILP_TRY(maps_.depth.supported.resize(supported_words(camera_.width), camera_.height));
  std::fill_n(maps_.depth.supported.view().data, maps_.depth.supported.view().area(), std::uint64_t{0});
  return {};
}

Status DenseMatcher::depth_band() {
  if (panel_ == 0 && row_ == 0) ILP_TRY(begin_depth());
  const std::int32_t end = std::min(row_ + 4 * band_rows, camera_.height);
  ILP_TRY(depth_rows(panel().pair, camera_, matcher_.result(), row_, end, maps_.depth.view()));
  row_ = end;
  if (row_ < camera_.height) return {};
  if (++panel_ < plan_.count) return begin_panel();
  phase_ = Phase::errors;
  return {};
}

void DenseMatcher::state_geometry(DepthRecord& record) {
  const RigidTransform partner_from_this =
      compose(cam_from_world(pose_of(partner_.pose)), inverse(cam_from_world(pose_of(pose_))));
  Vec2 epipole;
  if (plan_.blind_radius_px > 0 && epipole_of(camera_, partner_from_this, epipole)) {
    record.epipole_x = epipole.x();
    record.epipole_y = epipole.y();
    record.blind_radius_px = plan_.blind_radius_px;
  }
  const ImageView<const float> inverse_depth = static_cast<const ImageBuffer<float>&>(maps_.depth.inverse).view();
  record.pose_sigma =
      median_depth_error_of_poses(partner_from_this, partner_.step, camera_, inverse_depth, work_.record.pose_errors);
}

Status DenseMatcher::state_errors() {
  if (residual_.count >= min_vertical_residuals && residual_.median_px() > max_vertical_residual_px) {
    return give_up_partner(DepthVerdict::rectification_impossible,
                           {StatusCode::rectification_impossible, pose_.id,
                            static_cast<std::int64_t>(RectificationFault::poses_contradict)});
  }
  record_ = {};
  mask_ = {};
  record_.id = pose_.id;
  record_.strip_id = pose_.strip_id;
  record_.partner_id = partner_.pose.id;
  record_.baseline = distance(pose_, partner_.pose);
  record_.disparity_per_inverse_depth_px = plan_.disparity_per_inverse_depth_px;
  drop_uncertain_depths(mission_.largest_depth_sigma, maps_.depth.view());
  state_geometry(record_);
  phase_ = Phase::quality;
  return {};
}

Status DenseMatcher::state_quality() {
  RecordWorkspace& w = work_.record;
  ILP_TRY(w.sigma_code.resize(camera_.width, camera_.height));
  record_.supported = code_sigma(maps_.depth.view(), record_.disparity_per_inverse_depth_px, w.sigma_code.view().data);
  phase_ = Phase::mask;
  return seen_cells(maps_.depth.inverse.view(), maps_.depth.sigma.view(), camera_.fx, 1, now_);
}

/// The mask of the ground that is new.
Status DenseMatcher::claim_ground() {
  RecordWorkspace& w = work_.record;
  after_ = state_;
  ILP_TRY(use_coverage_of(pose_.id));
  ILP_TRY(w.mask.resize(camera_.width, camera_.height));
  ILP_TRY(w.codes.resize(camera_.width, camera_.height));
  MaskCounts counts;
  ILP_TRY(
      newly_seen_mask(maps_.depth.sigma.view(), after_.coverage, now_, partner_.finer_steps, w.mask.view(), counts));
  const auto area = static_cast<double>(w.mask.view().area());
  if (counts.matched < smallest_matched_share * area) {
    return give_up_partner(DepthVerdict::too_few_valid, {});
  }
  record_.valid = counts.matched;
  mask_.newly_seen = counts.newly_seen;
  phase_ = Phase::coding;
  return {};
}

Status DenseMatcher::choose_coding() {
  const RecordWorkspace& w = work_.record;
  DepthCoding coding;
  ILP_TRY(choose_depth_coding(maps_.depth.inverse.view(), maps_.depth.sigma.view(), w.mask.view(),
                              plan_.disparity_per_inverse_depth_px / plan_.baseline, plan_.baseline,
                              1.0 / mission_.depth_step_px, coding));
  record_.offset = coding.offset;
  record_.step = coding.step;
  phase_ = Phase::codes;
  return {};
}

Status DenseMatcher::code_depth() {
  RecordWorkspace& w = work_.record;
  ILP_TRY(encode_depth(maps_.depth.inverse.view(), maps_.depth.sigma.view(), w.mask.view(),
                       {record_.offset, record_.step}, w.codes.view()));
  state_median_sigma(record_);
  phase_ = Phase::mask_code;
  return {};
}

void DenseMatcher::state_median_sigma(DepthRecord& record) {
  const ImageView<const std::uint8_t> sigma_codes = work_.record.sigma_code.view();
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

PairGround DenseMatcher::ground() const {
  return {maps_.depth.inverse.view(), maps_.depth.sigma.view(), work_.record.mask.view(), now_};
}

Status DenseMatcher::begin_carry() {
  after_ = state_;
  ILP_TRY(use_coverage_of(pose_.id));
  ILP_TRY(cover_passed(pose_.id, next_.id, true));
  phase_ = Phase::coverage;
  return begin_carrying(camera_, ground(), work_.record.coverage, after_.coverage);
}

Status DenseMatcher::carry_ground() {
  const RigidTransform next_from_this =
      compose(cam_from_world(pose_of(next_)), inverse(cam_from_world(pose_of(pose_))));
  bool more = false;
  ILP_TRY(carry_coverage_slice(camera_, ground(), next_from_this, work_.record.coverage, after_.coverage, more));
  if (!more) phase_ = Phase::cells;
  return {};
}

Status DenseMatcher::describe_cells() {
  phase_ = Phase::record;
  return measure_cells(record_);
}

Status DenseMatcher::record_depth() {
  return write(record_, mask_, next_.id);
}

/// The pair has given no depth: what is `reported` counts if the partner is the next keyframe, which is tried
/// otherwise.
Status DenseMatcher::give_up_partner(DepthVerdict verdict, Status reported) {
  if (partner_.pose.id != next_.id) {
    partner_ = partner_of(next_, sampling_steps(mission_.claim_ratio));
    const Status begun = begin_pair(pose_, verdict);
    if (verdict == DepthVerdict::ok) return begun;
    reported = {};
  }
  ILP_TRY(record_without_depth(pose_, verdict));
  return reported;
}

/// Of cells with a few pixels of depth nobody can say later which part was seen.
Status DenseMatcher::measure_cells(DepthRecord& record) {
  ILP_TRY(cell_depths(maps_.depth.inverse.view(), maps_.depth.sigma.view(), smallest_cell, cell_depths_));
  const auto cells = static_cast<std::size_t>(now_.columns) * static_cast<std::size_t>(now_.rows);
  for (std::size_t i = 0; i < cells; ++i) {
    if (!(cell_depths_[i] > 0)) now_.quality[i] = 0;
  }
  record.cells.bytes = static_cast<std::uint32_t>(cells * (1 + sizeof(float)));
  return {};
}

Status DenseMatcher::plane_between(std::int64_t from_keyframe_id, std::int64_t to_keyframe_id, Mat3& to_from_from) {
  to_from_from = Mat3::Identity();
  for (std::int64_t id = from_keyframe_id + 1; id <= to_keyframe_id; ++id) {
    KeyframeRecord keyframe;
    ILP_TRY(get(store_, id, keyframe));
    Mat3 plane;
    for (int i = 0; i < 9; ++i) plane(i / 3, i % 3) = keyframe.plane_from_previous[i];
    to_from_from = plane * to_from_from;
  }
  return {};
}

/// A strip is abandoned after two failures in a row, so that a pair reaches across one keyframe at most.
Status DenseMatcher::cover_passed(std::int64_t first_id, std::int64_t second_id, bool with_depth) {
  after_.passed_keyframe_id = 0;
  if (second_id != first_id + 2) return {};
  const std::int64_t passed_id = first_id + 1;
  Mat3 passed_from_first;
  Mat3 second_from_passed;
  ILP_TRY(plane_between(first_id, passed_id, passed_from_first));
  ILP_TRY(plane_between(passed_id, second_id, second_from_passed));
  ILP_TRY(clear_coverage(camera_.width, camera_.height, after_.passed));
  const ImageView<const float> sigma = maps_.depth.sigma.view();
  // The mask of an image without a pose depends on what is covered, not on how well that was seen.
  constexpr std::uint8_t covered = 1;
  const auto known = [&](std::int32_t x, std::int32_t y) {
    // Without depth the image of the first is sent whole.
    const bool sent = !with_depth || sigma.at(x, y) > 0 || after_.coverage.at(x, y);
    return sent ? covered : std::uint8_t{0};
  };
  cover_over_plane(passed_from_first.inverse(), known, after_.passed);
  cover_over_plane(
      second_from_passed, [](std::int32_t, std::int32_t) { return covered; }, after_.passed);
  after_.passed_keyframe_id = passed_id;
  return {};
}

/// Carries the ground that earlier pairs have reconstructed to the next keyframe with a pose; 0 when there is none.
Status DenseMatcher::carry_without_depth(const PoseRecord& pose, std::int64_t& next_id) {
  next_id = 0;
  PoseRecord next;
  Successor state = Successor::none;
  if (pose.state != PoseState::failed) ILP_TRY(next_with_pose(store_, pose, pose.id, next, state));
  if (state != Successor::final) return {};
  ILP_TRY(cover_passed(pose.id, next.id, false));
  Mat3 next_from_this;
  ILP_TRY(plane_between(pose.id, next.id, next_from_this));
  before_ = after_.coverage;
  ILP_TRY(clear_coverage(camera_.width, camera_.height, after_.coverage));
  const auto known = [this](std::int32_t x, std::int32_t y) {
    return before_.at(x, y) ? before_.seen.at(x, y) : std::uint8_t{0};
  };
  cover_over_plane(next_from_this.inverse(), known, after_.coverage);
  next_id = next.id;
  return {};
}

Status DenseMatcher::record_without_depth(const PoseRecord& pose, DepthVerdict verdict) {
  DepthRecord record;
  MaskRecord new_ground;
  record.id = pose.id;
  record.strip_id = pose.strip_id;
  record.verdict = verdict;
  after_ = state_;
  const bool passed = pose.id == after_.passed_keyframe_id;
  if (!passed) ILP_TRY(use_coverage_of(pose.id));
  const Coverage& coverage = passed ? after_.passed : after_.coverage;
  ILP_TRY(work_.record.mask.resize(camera_.width, camera_.height));
  const ImageView<std::uint8_t> mask = work_.record.mask.view();
  for (std::size_t i = 0; i < mask.area(); ++i) {
    const bool covered = coverage.at(i);
    mask.data[i] = covered ? 0 : 255;
    new_ground.newly_seen += covered ? 0 : 1;
  }
  std::int64_t next_id = after_.coverage_keyframe_id;
  if (!passed) ILP_TRY(carry_without_depth(pose, next_id));
  ILP_TRY(code_mask(new_ground));
  return write(record, new_ground, next_id);
}

/// A part of the pair, or of its coverage, cannot be read: the image of the keyframe is sent whole.
Status DenseMatcher::record_given_up() {
  const std::int64_t id = cursor_.first + 1;
  PoseRecord pose;
  const Status known = get(store_, id, pose);
  if (is_transient(known)) return known;
  if (known.ok()) {
    const Status recorded = record_without_depth(pose, DepthVerdict::too_few_valid);
    if (recorded.ok() || is_transient(recorded)) return recorded;
  }
  KeyframeRecord keyframe;
  const Status there = get(store_, id, keyframe);
  if (is_transient(there)) return there;
  DepthRecord record;
  MaskRecord new_ground;
  record.id = id;
  record.strip_id = there.ok() ? keyframe.strip_id : 0;
  record.verdict = DepthVerdict::too_few_valid;
  ILP_TRY(work_.record.mask.resize(camera_.width, camera_.height));
  const ImageView<std::uint8_t> mask = work_.record.mask.view();
  std::fill_n(mask.data, mask.area(), std::uint8_t{255});
  new_ground.newly_seen = static_cast<std::uint32_t>(mask.area());
  after_ = state_;
  after_.passed_keyframe_id = 0;
  ILP_TRY(code_mask(new_ground));
  return write(record, new_ground, 0);
}

Status DenseMatcher::code_mask(MaskRecord& mask) {
  RecordWorkspace& w = work_.record;
  std::size_t size = 0;
  ILP_TRY(encode_mask(w.mask.view(), w.mask_bytes.data(), w.mask_bytes.size(), size));
  mask.code.bytes = static_cast<std::uint32_t>(size);
  return {};
}

Status DenseMatcher::write(DepthRecord& record, MaskRecord& mask, std::int64_t next_coverage_id) {
  RecordWorkspace& w = work_.record;
  mask.id = record.id;
  mask.width = record.width = camera_.width;
  mask.height = record.height = camera_.height;
  after_.coverage_keyframe_id = next_coverage_id;

  patience_.begin_writing();
  StepTransaction transaction(store_, checkpoint);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, record));
  if (record.values.bytes != 0) {
    const ImageView<const std::uint16_t> codes = w.codes.view();
    const ImageView<const std::uint8_t> sigma = w.sigma_code.view();
    ILP_TRY(write_blob<DepthRecord>(store_, "values", record.id, 0, bytes_of(codes)));
    ILP_TRY(write_blob<DepthRecord>(store_, "sigma", record.id, 0, bytes_of(sigma)));
    const std::size_t cells = record.cells.bytes / (1 + sizeof(float));
    const std::span<const std::uint8_t> quality(now_.quality.data(), cells);
    const ImageView<const float> depths(cell_depths_.data(), static_cast<std::int32_t>(cells), 1);
    ILP_TRY(write_blob<DepthRecord>(store_, "cells", record.id, 0, quality));
    ILP_TRY(write_blob<DepthRecord>(store_, "cells", record.id, cells, bytes_of(depths)));
  }
  ILP_TRY(put(store_, mask));
  ILP_TRY(write_blob<MaskRecord>(store_, "code", mask.id, 0, {w.mask_bytes.data(), mask.code.bytes}));
  ILP_TRY(transaction.commit(Cursor{record.id, cursor_.second}, after_, cursor_, state_));
  patience_.end_writing();
  phase_ = Phase::idle;
  return {};
}

Status DenseMatcher::advance(bool& picked, bool& waits) {
  switch (phase_) {
    case Phase::idle:
      return pick(picked);
    case Phase::begin:
      return begin();
    case Phase::resample:
      return resample_band();
    case Phase::match:
      return match_band(waits);
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
      phase_ = Phase::passed;
      return code_mask(mask_);
    case Phase::passed:
      return begin_carry();
    case Phase::coverage:
      return carry_ground();
    case Phase::cells:
      return describe_cells();
    case Phase::record:
      return record_depth();
  }
  return {};
}

StepResult DenseMatcher::step() {
  if (mission_.safe_mode) return {};
  bool pending = true;
  bool waits = false;
  const Phase phase = phase_;
  const Status status = advance(pending, waits);
  if (status.ok()) return {{}, pending, waits ? Then::wait : Then::go_on};
  // Of the pair, or of the next one that takes its place.
  const bool of_pair = phase == Phase::begin || phase >= Phase::errors;
  if (of_pair && (status.is(StatusCode::rectification_impossible) || status.is(StatusCode::disparity_range_exceeded))) {
    return {status, true};
  }
  return patience_.failed(cursor_.first + 1, status);
}

}  // namespace ilp
