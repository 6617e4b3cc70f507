#include "fsw/vision/stereo/stereo_matcher.hpp"

#include "fsw/vision/stereo/disparity_recovery.hpp"

namespace ilp {
namespace {

template <typename A, typename B>
bool same_size(const A& a, const B& b) {
  return a.width == b.width && a.height == b.height;
}

bool sensible(const StereoParams& p) {
  return p.window_radius >= 1 && p.window_radius <= max_window_radius && p.noise_grey > 0 && p.noise_grey < 256 &&
         p.min_ncc > 0 && p.min_ncc < 1 && p.edge_grey >= 1 && p.uniqueness_permille >= 0 &&
         p.uniqueness_permille < 1000 && p.min_texture_grey >= 0 && p.segment_step_px >= 0 &&
         p.smoothing_step_px >= 0 && p.out_of_view_cost >= 0 && p.out_of_view_cost <= max_matching_cost &&
         p.recovery_neighbours >= 0 && p.recovery_neighbours <= 8 && p.recovery_min_ncc > 0 && p.recovery_min_ncc < 1;
}

}  // namespace

Status StereoMatcher::begin(GrayView left, GrayView right, MaskView left_valid, MaskView right_valid,
                            const DisparityRange& range, const StereoParams& params, StereoWorkspace& workspace,
                            const DisparityView& result) {
  workspace_ = nullptr;
  if (left.empty() || !same_size(left, right) || !same_size(left, left_valid) || !same_size(left, right_valid) ||
      !same_size(left, result.disparity_px) || !same_size(left, result.sigma_px)) {
    return {StatusCode::invalid_argument, 1, left.width};
  }
  if (left.width > limits::max_rectified_width || left.height > limits::max_rectified_height) {
    return {StatusCode::image_too_large, left.width, left.height};
  }
  if (range.max_px < range.min_px || range.min_px < -limits::max_rectified_width ||
      range.max_px > limits::max_rectified_width) {
    return {StatusCode::invalid_argument, 2, range.max_px};
  }
  if (range.count() > limits::max_disparities) {
    return {StatusCode::disparity_range_exceeded, range.count(), limits::max_disparities};
  }
  if (!sensible(params)) return {StatusCode::invalid_argument, 3};
  rows_ = {};
  rows_.left = left;
  rows_.right = right;
  rows_.left_valid = left_valid;
  rows_.right_valid = right_valid;
  rows_.min_disparity = range.min_px;
  rows_.padded_disparities = (range.count() + disparity_block - 1) / disparity_block * disparity_block;
  rows_.radius = params.window_radius;
  const auto side = static_cast<double>(2 * params.window_radius + 1);
  rows_.out_of_view_cost = params.out_of_view_cost;
  rows_.damping = static_cast<float>(side * side * params.noise_grey * params.noise_grey);
  range_ = range;
  params_ = params;
  penalties_ = make_path_penalties(params);
  result_ = result;
  next_filtered_ = 0;
  workspace_ = &workspace;
  return {};
}

void StereoMatcher::match_next_row() {
  StereoWorkspace& w = *workspace_;
  const std::int32_t y = rows_.next_row;
  compute_ncc_row(rows_, w.ncc, w.ncc_row.data(), w.cost_row.data(), w.variance_row.data());
  aggregate_row(rows_.left, y, rows_.padded_disparities, penalties_, w.cost_row.data(), w.paths, w.sum_row.data());
  select_row(rows_, range_.count(), params_, w.ncc_row.data(), w.sum_row.data(), w.variance_row.data(), w.selection,
             result_.disparity_px.row(y), result_.sigma_px.row(y));
  if (params_.keep_order) {
    keep_ordered_row(rows_.left.width, result_.disparity_px.row(y), result_.sigma_px.row(y), w.ordering);
  }
  connect_segments_row(result_.disparity_px, result_.sigma_px, y, static_cast<float>(params_.segment_step_px),
                       w.segments);
}

void StereoMatcher::filter_next_row() {
  // Each stage needs the row below its own from the stage before.
  const std::int32_t y = next_filtered_++;
  if (y < rows_.left.height) {
    remove_small_segments_row(result_.sigma_px, y, params_.min_segment_px, workspace_->segments);
  }
  if (y < 1) return;
  recover_row(rows_, range_, params_, y - 1, result_.disparity_px, result_.sigma_px);
  smooth_row(result_.disparity_px, result_.sigma_px, y - 1, static_cast<float>(params_.smoothing_step_px),
             workspace_->smoothing);
}

Status StereoMatcher::step(std::int32_t rows, bool& pending) {
  pending = false;
  if (workspace_ == nullptr) return StatusCode::not_ready;
  if (rows < 1) return {StatusCode::invalid_argument, 4, rows};
  const std::int32_t height = rows_.left.height;
  const std::int32_t filtered_end = height + 1 + smoothing_radius;
  for (std::int32_t i = 0; i < rows && next_filtered_ < filtered_end; ++i) {
    if (rows_.next_row < height) {
      match_next_row();
    } else {
      filter_next_row();
    }
  }
  pending = next_filtered_ < filtered_end;
  return {};
}

}  // namespace ilp
