#include "fsw/vision/stereo/match/stereo_matcher.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/vision/stereo/match/disparity_recovery.hpp"
#include "fsw/vision/stereo/ordered/slope_steps.hpp"

namespace ilp {
namespace {

bool sensible(const StereoParams& p) {
  return p.window_radius >= 1 && p.window_radius <= max_window_radius && p.noise_grey > 0 && p.noise_grey < 256 &&
         p.min_ncc > 0 && p.min_ncc < 1 && p.uniqueness_permille >= 0 && p.uniqueness_permille < 1000 &&
         p.min_texture_grey >= 0 && p.border_step_px >= 0 && p.recovery_step_px >= 0 && p.surface_step_px >= 0 &&
         p.surface_step_px < limits::max_rectified_width && p.gap_reach_px >= 0 && p.recovery_neighbours >= 0 &&
         p.recovery_neighbours <= 8 && p.recovery_min_ncc > 0 && p.recovery_min_ncc < 1;
}

// A shorter range saves less than the coarse map costs.
constexpr std::int32_t min_narrowed_disparities = 2 * disparity_block + 1;
// Small things fill a small window only.
constexpr int coarse_window_radius = 1;
// Of a match outside the other image: between a right and a chance match.
constexpr int out_of_view_cost = 30;
// Change of the disparity that still connects neighbours.
constexpr float segment_step_px = 1.5F;
// Neighbours that differ by more do not average.
constexpr float smoothing_step_px = 2.5F;
// A smaller image has no room for a window and its support.
constexpr std::int32_t min_narrowed_side = 2 * search_tile;

NccRows make_rows(const StereoPairView& pair, const DisparityRange& range, const StereoParams& params) {
  NccRows rows;
  rows.left = pair.left;
  rows.right = pair.right;
  rows.left_valid = pair.left_valid;
  rows.right_valid = pair.right_valid;
  rows.min_disparity = range.min_px;
  rows.padded_disparities = whole_blocks(range.count());
  rows.radius = params.window_radius;
  const auto side = static_cast<double>(2 * params.window_radius + 1);
  rows.out_of_view_cost = out_of_view_cost;
  rows.damping = static_cast<float>(side * side * params.noise_grey * params.noise_grey);
  return rows;
}

/// The amount by which the sum of paths of a unique disparity is lower than any other's.
std::int32_t uniqueness_lead(const StereoParams& params) {
  return (aggregated_paths * max_matching_cost * params.uniqueness_permille + 999) / 1000;
}

/// The coarse level's search range for a range at full resolution.
DisparityRange coarse_range(const DisparityRange& range) {
  static_assert(coarse_step == 4);
  return {range.min_px >> 2, range.max_px >> 2};
}

/// Memory for the coarse pair: its segments are in the first quarter of the links.
std::uint8_t* spare_bytes(PixelForest& segments) {
  return reinterpret_cast<std::uint8_t*>(segments.links.data() + segments.links.size() / 4);
}
static_assert(coarse_pair_bytes(limits::max_rectified_width, limits::max_rectified_height) <=
              limits::max_rectified_pixels / 4 * 3 * sizeof(std::int32_t));

}  // namespace

Status StereoMatcher::begin(GrayView left, GrayView right, MaskView left_valid, MaskView right_valid,
                            const DisparityRange& range, const StereoParams& params, StereoWorkspace& workspace,
                            const DisparityView& result) {
  workspace_ = nullptr;
  if (left.empty() || !same_size(left, right) || !same_size(left, left_valid) || !same_size(left, right_valid) ||
      !same_size(left, result.disparity_px) || !same_size(left, result.sigma_px)) {
    return out_of_range(Argument::rectified_size, left.width);
  }
  if (left.width > limits::max_rectified_width || left.height > limits::max_rectified_height) {
    return {StatusCode::image_too_large, left.width, left.height};
  }
  if (range.max_px < range.min_px || range.min_px < -limits::max_rectified_width ||
      range.max_px > limits::max_rectified_width) {
    return out_of_range(Argument::disparity_range, range.max_px);
  }
  if (range.count() > limits::max_disparities) {
    return {StatusCode::disparity_range_exceeded, range.count(), limits::max_disparities};
  }
  if (!sensible(params)) return out_of_range(Argument::stereo_parameters);
  const StereoPairView pair{left, right, left_valid, right_valid};
  rows_ = make_rows(pair, range, params);
  range_ = range;
  params_ = params;
  penalties_ = make_path_penalties(params);
  result_ = {result.disparity_px, result.sigma_px, {workspace.kinds.data(), left.width, left.height}};
  workspace_ = &workspace;
  phase_ = Phase::match;
  row_ = 0;
  if (params.coarse_to_fine && range.count() >= min_narrowed_disparities &&
      std::min(left.width, left.height) >= min_narrowed_side) {
    phase_ = Phase::reduce;
    coarse_ = make_coarse_pair(spare_bytes(workspace.segments), left.width, left.height);
    coarse_range_ = coarse_range(range);
    StereoParams coarse_params = params;
    coarse_params.window_radius = coarse_window_radius;
    coarse_rows_ = make_rows(coarse_.view(), coarse_range_, coarse_params);
    coarse_result_ = {result.disparity_px.crop(0, 0, left.width / coarse_step, left.height / coarse_step),
                      result.sigma_px.crop(0, 0, left.width / coarse_step, left.height / coarse_step)};
  } else {
    workspace.search.fill(search_everything(left.width, rows_.padded_disparities));
  }
  return {};
}

std::int32_t StereoMatcher::rows_at_once() const {
  return params_.matcher == StereoMatcherChoice::ordered_scanline ? max_rows_at_once : 1;
}

void StereoMatcher::choose(const NccRows& rows, std::int32_t y, std::int32_t count, std::int32_t disparities) {
  StereoWorkspace& w = *workspace_;
  if (params_.matcher == StereoMatcherChoice::semi_global) {
    aggregate_row(rows.left, y, rows.search, rows.padded_disparities, disparities, uniqueness_lead(params_), penalties_,
                  w.cost_row.data(), w.matcher.semi_global.paths, w.rows[0].winners.data());
    return;
  }
  const std::int16_t* ncc[max_rows_at_once] = {};
  RowWinner* winners[max_rows_at_once] = {};
  for (std::int32_t k = 0; k < count; ++k) {
    ncc[k] = w.rows[static_cast<std::size_t>(k)].ncc();
    winners[k] = w.rows[static_cast<std::size_t>(k)].winners.data();
  }
  find_ordered_rows(rows.search, rows.padded_disparities, params_, ncc, count, w.matcher.ordered, winners);
  for (std::int32_t k = 0; k < count; ++k) {
    match_slope_steps(rows.left.width, rows.padded_disparities, ncc[k], winners[k]);
  }
}

void StereoMatcher::match_row(NccRows& rows, const SearchRow& search, const DisparityRange& range,
                              const DisparityView& result) {
  StereoWorkspace& w = *workspace_;
  const std::int32_t first = rows.next_row / rows_at_once() * rows_at_once();
  MatchedRow& latest = w.rows[static_cast<std::size_t>(rows.next_row - first)];
  compute_ncc_row(rows, search, w.ncc, latest.ncc(), rows_at_once() > 1 ? nullptr : w.cost_row.data(),
                  latest.variance.data());
  const std::int32_t count = rows.next_row - first;
  if (count < rows_at_once() && rows.next_row < rows.left.height) return;
  choose(rows, first, count, range.count());
  for (std::int32_t y = first; y < first + count; ++y) {
    const MatchedRow& row = w.rows[static_cast<std::size_t>(y - first)];
    finish_row(rows, y, range, row, row.variance.data(), result);
  }
}

/// What follows from the winners of a row.
void StereoMatcher::finish_row(const NccRows& rows, std::int32_t y, const DisparityRange& range, const MatchedRow& row,
                               const float* variance, const DisparityView& result) {
  StereoWorkspace& w = *workspace_;
  float* disparity = result.disparity_px.row(y);
  float* sigma = result.sigma_px.row(y);
  select_row(rows, y, range.count(), params_, row.ncc(), row.winners.data(), variance, w.selection, disparity, sigma);
  if (params_.matcher == StereoMatcherChoice::semi_global && params_.keep_order) {
    keep_ordered_row(rows.left.width, disparity, sigma, w.matcher.semi_global.ordering);
  }
  connect_segments_row(result.disparity_px, result.sigma_px, y, segment_step_px, w.segments);
}

void StereoMatcher::filter_row(std::int32_t y) {
  // Each stage needs rows below its own from the stage before.
  if (y < rows_.left.height) {
    remove_small_segments_row(result_.sigma_px, y, params_.min_segment_px, workspace_->segments);
  }
  const std::int32_t checked = y - border_reach;
  if (checked >= 0 && checked < rows_.left.height) {
    check_border_row(rows_.left_valid, rows_.right_valid, params_, checked, result_.disparity_px, result_.sigma_px,
                     workspace_->border);
  }
  const std::int32_t recovered = checked - 1;
  if (recovered < 0) return;
  recover_row(rows_, range_, params_, recovered, result_.disparity_px, result_.sigma_px);
  if (recovered < rows_.left.height) {
    std::fill_n(result_.kind.row(recovered), rows_.left.width, DisparityKind::measured);
  }
  decide_edges_row(rows_, params_, recovered, result_, workspace_->edges);
  const std::int32_t decided = recovered - edge_reach;
  if (decided < 0) return;
  smooth_row(result_, decided, smoothing_step_px, workspace_->smoothing);
  const std::int32_t smoothed = decided - smoothing_radius;
  if (smoothed < 0) return;
  if (params_.matcher == StereoMatcherChoice::ordered_scanline) {
    // The path had the order, but recovery and fractions of a pixel may break it.
    keep_ordered_row(rows_.left.width, result_.disparity_px.row(smoothed), result_.sigma_px.row(smoothed),
                     workspace_->matcher.semi_global.ordering);
  }
  const float* __restrict sigma = result_.sigma_px.row(smoothed);
  DisparityKind* __restrict kind = result_.kind.row(smoothed);
  for (std::int32_t x = 0; x < rows_.left.width; ++x) kind[x] = sigma[x] > 0 ? kind[x] : DisparityKind::none;
}

std::int32_t StereoMatcher::rows_of(Phase phase) const {
  switch (phase) {
    case Phase::reduce:
    case Phase::match_coarse:
    case Phase::clean_coarse:
      return coarse_.left.height;
    case Phase::narrow:
      return (rows_.left.height + search_tile - 1) / search_tile;
    case Phase::match:
      return rows_.left.height;
    case Phase::filter:
      return rows_.left.height + border_reach + 1 + edge_reach + smoothing_radius;
    case Phase::propose:
      return params_.gap_reach_px > 0 ? rows_.left.height : 0;
    case Phase::connect:
    case Phase::accept:
      return params_.gap_reach_px > 0 && workspace_->gaps.proposals > 0 ? rows_.left.height : 0;
    case Phase::done:
      break;
  }
  return 0;
}

void StereoMatcher::do_row() {
  StereoWorkspace& w = *workspace_;
  switch (phase_) {
    case Phase::reduce:
      return reduce_row({rows_.left, rows_.right, rows_.left_valid, rows_.right_valid}, row_, coarse_);
    case Phase::match_coarse:
      return match_row(coarse_rows_, search_everything(coarse_.left.width, coarse_rows_.padded_disparities),
                       coarse_range_, coarse_result_);
    case Phase::clean_coarse:
      return remove_small_segments_row(coarse_result_.sigma_px, row_,
                                       params_.min_segment_px / (coarse_step * coarse_step), w.segments);
    case Phase::narrow:
      w.search[static_cast<std::size_t>(row_)] = search_of_band(
          {coarse_result_.disparity_px, coarse_result_.sigma_px, coarse_.left_valid}, rows_.left.width, row_, range_);
      return;
    case Phase::match:
      return match_row(rows_, w.search[static_cast<std::size_t>(row_ / search_tile)], range_, result_);
    case Phase::filter:
      return filter_row(row_);
    case Phase::propose:
      if (row_ == 0) begin_gaps(w.gaps);
      return propose_gap_row(rows_, params_, row_, result_, w.gaps);
    case Phase::connect:
      return connect_gap_row(rows_.left_valid, result_, row_, w.segments);
    case Phase::accept:
      return accept_gap_row(result_, row_, w.segments);
    case Phase::done:
      return;
  }
}

void StereoMatcher::advance() {
  if (++row_ < rows_of(phase_)) return;
  row_ = 0;
  do {
    phase_ = static_cast<Phase>(static_cast<std::uint8_t>(phase_) + 1);
  } while (phase_ != Phase::done && rows_of(phase_) == 0);  // bound: the phases
}

Result<bool> StereoMatcher::step(std::int32_t rows) {
  if (workspace_ == nullptr) return StatusCode::not_ready;
  if (rows < 1) return out_of_range(Argument::rows, rows);
  for (std::int32_t i = 0; i < rows && phase_ != Phase::done; ++i) {
    do_row();
    advance();
  }
  return phase_ != Phase::done;
}

}  // namespace ilp
