#include "fsw/vision/stereo/match/disparity_smoothing.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

constexpr float far_away = 1e9F;
constexpr float all_pairs = 2 * smoothing_radius * (smoothing_radius + 1);

// Weights of the indications of an error, chosen on rendered terrain so that 60 to 75 % of the errors are within one
// sigma and 92 % within two (stereo-peers states both).
constexpr float matching_weight = 0.45F;  ///< of the window's own error: neighbours with other noise were averaged
constexpr float alone_weight = 0.9F;      ///< of the same for a pixel without neighbours to average with
constexpr float roughness_weight = 0.7F;  ///< of the scatter of the neighbours about the plane through the pixel
constexpr float edge_error_px = 0.7F;     ///< without neighbours that agree: the window may belong to another surface
constexpr float slope_error_px = 0.9F;    ///< per px of disparity and px: a window sees a slope foreshortened
constexpr float unknown_slope = 0.25F;
constexpr float max_slope = 1;
constexpr float floor_px = 0.03F;
constexpr float max_sigma_px = 4;

float* row_of(SmoothingWorkspace& w, std::int32_t y) {
  return w.rows[static_cast<std::size_t>((y + smoothing_rows) % smoothing_rows)].data() + smoothing_radius;
}

void take_row(const ImageView<float>& disparity_px, ImageView<const float> sigma_px, std::int32_t y, float* out) {
  std::fill_n(out - smoothing_radius, smoothing_radius, far_away);
  std::fill_n(out + disparity_px.width, smoothing_radius, far_away);
  if (y < 0 || y >= disparity_px.height) {
    std::fill_n(out, disparity_px.width, far_away);
    return;
  }
  const float* __restrict d = disparity_px.row(y);
  const float* __restrict s = sigma_px.row(y);
  for (std::int32_t x = 0; x < disparity_px.width; ++x) out[x] = s[x] > 0 ? d[x] : far_away;
}

struct PairSums {
  float* sum;
  float* count;    ///< of values in `sum`
  float* scatter;  ///< squared distances between the pairs' means and the centre
};

/// Adds the pairs (before[i], after[i]) that agree with their centre. Several at once, because the sums dominate the
/// time.
template <int Pairs>
void add_pairs(const float* __restrict centre, const float* const (&before)[Pairs], const float* const (&after)[Pairs],
               std::int32_t width, float max_step_px, const PairSums& sums) {
  float* __restrict sum = sums.sum;
  float* __restrict count = sums.count;
  float* __restrict scatter = sums.scatter;
  for (std::int32_t x = 0; x < width; ++x) {
    const float c = centre[x];
    float added = 0;
    float values = 0;
    float squares = 0;
    for (int i = 0; i < Pairs; ++i) {
      const float b = before[i][x];
      const float a = after[i][x];
      const bool agree = std::max(std::fabs(b - c), std::fabs(a - c)) <= max_step_px;
      const float away = 0.5F * (b + a) - c;
      added += agree ? b + a : 0.0F;
      values += agree ? 2.0F : 0.0F;
      squares += agree ? away * away : 0.0F;
    }
    sum[x] += added;
    count[x] += values;
    scatter[x] += squares;
  }
}

/// Pairs of the pixels in a row above and in the same row below.
void add_pairs_across(const float* centre, const float* above, const float* below, std::int32_t width,
                      float max_step_px, const PairSums& sums) {
  static_assert(smoothing_radius == 2);
  const float* const before[] = {above - 2, above - 1, above, above + 1, above + 2};
  const float* const after[] = {below + 2, below + 1, below, below - 1, below - 2};
  add_pairs(centre, before, after, width, max_step_px, sums);
}
void add_pairs_along(const float* centre, std::int32_t width, float max_step_px, const PairSums& sums) {
  const float* const before[] = {centre - 2, centre - 1};
  const float* const after[] = {centre + 2, centre + 1};
  add_pairs(centre, before, after, width, max_step_px, sums);
}

/// Square of the disparity's change per pixel; a usual value beside a gap.
float squared_slope(float left, float right, float above, float below) {
  const float most = std::max(std::max(left, right), std::max(above, below));
  constexpr float distance = 2 * smoothing_radius;
  const float x = (right - left) / distance;
  const float y = (below - above) / distance;
  const float known = std::min(x * x + y * y, max_slope * max_slope);
  return most >= 0.5F * far_away ? unknown_slope * unknown_slope : known;
}

float estimated_sigma(float sigma, float count, float scatter, float slope2) {
  const float pairs = 0.5F * (count - 1);
  const float matching = (pairs > 0 ? matching_weight : alone_weight) * sigma;
  const float roughness2 = roughness_weight * roughness_weight * scatter / std::max(pairs, 1.0F);
  const float edge2 = edge_error_px * edge_error_px * (all_pairs - pairs) / all_pairs;
  const float variance =
      matching * matching + roughness2 + edge2 + slope_error_px * slope_error_px * slope2 + floor_px * floor_px;
  return std::min(max_sigma_px, std::sqrt(variance));
}

void finish_row(const float* __restrict centre, const float* __restrict above, const float* __restrict below,
                const PairSums& sums, std::int32_t width, const DisparityKind* __restrict kind,
                float* __restrict disparity_px, float* __restrict sigma_px) {
  const float* __restrict sum = sums.sum;
  const float* __restrict count = sums.count;
  const float* __restrict scatter = sums.scatter;
  for (std::int32_t x = 0; x < width; ++x) {
    const float slope2 = squared_slope(centre[x - smoothing_radius], centre[x + smoothing_radius], above[x], below[x]);
    const float measured = estimated_sigma(sigma_px[x], count[x], scatter[x], slope2);
    const float stated = kind[x] == DisparityKind::resolved ? sigma_px[x] : measured;
    const bool valid = sigma_px[x] > 0;
    disparity_px[x] = valid ? sum[x] / count[x] : 0.0F;
    sigma_px[x] = valid ? stated : 0.0F;
  }
}

void smooth(const DisparityView& map, std::int32_t y, float max_step_px, SmoothingWorkspace& w) {
  const auto& [disparity_px, sigma_px, kind] = map;
  if (y == 0) {
    for (std::int32_t above = -smoothing_radius - 1; above < 0; ++above) {
      take_row(disparity_px, sigma_px, -1, row_of(w, above));
    }
  }
  take_row(disparity_px, sigma_px, y, row_of(w, y));
  const std::int32_t target = y - smoothing_radius;
  if (target < 0 || target >= disparity_px.height) return;
  const std::int32_t width = disparity_px.width;
  const float* centre = row_of(w, target);
  const PairSums sums{w.sum.data(), w.count.data(), w.scatter.data()};
  std::copy_n(centre, width, sums.sum);
  std::fill_n(sums.count, width, 1.0F);
  std::fill_n(sums.scatter, width, 0.0F);
  add_pairs_along(centre, width, max_step_px, sums);
  for (std::int32_t dy = 1; dy <= smoothing_radius; ++dy) {
    add_pairs_across(centre, row_of(w, target - dy), row_of(w, target + dy), width, max_step_px, sums);
  }
  finish_row(centre, row_of(w, target - smoothing_radius), row_of(w, target + smoothing_radius), sums, width,
             kind.row(target), disparity_px.row(target), sigma_px.row(target));
}

}  // namespace

void smooth_row(const DisparityView& map, std::int32_t y, float max_step_px, SmoothingWorkspace& w) {
  with_widest_vectors([&] { smooth(map, y, max_step_px, w); });
}

}  // namespace ilp
