#include "fsw/vision/stereo/disparity_smoothing.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

constexpr float far_away = 1e9F;

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

/// Adds the pairs (before, after) that agree with their centre.
void add_pairs(const float* __restrict centre, const float* __restrict before, const float* __restrict after,
               std::int32_t width, float max_step_px, float* __restrict sum, float* __restrict count) {
  for (std::int32_t x = 0; x < width; ++x) {
    const float spread = std::max(std::fabs(before[x] - centre[x]), std::fabs(after[x] - centre[x]));
    const bool agree = spread <= max_step_px;
    sum[x] += agree ? before[x] + after[x] : 0.0F;
    count[x] += agree ? 2.0F : 0.0F;
  }
}

}  // namespace

void smooth_row(const ImageView<float>& disparity_px, ImageView<const float> sigma_px, std::int32_t y,
                float max_step_px, SmoothingWorkspace& w) {
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
  float* sum = w.sum.data();
  float* count = w.count.data();
  std::copy_n(centre, width, sum);
  std::fill_n(count, width, 1.0F);
  for (std::int32_t dx = 1; dx <= smoothing_radius; ++dx) {
    add_pairs(centre, centre - dx, centre + dx, width, max_step_px, sum, count);
  }
  for (std::int32_t dy = 1; dy <= smoothing_radius; ++dy) {
    const float* above = row_of(w, target - dy);
    const float* below = row_of(w, target + dy);
    for (std::int32_t dx = -smoothing_radius; dx <= smoothing_radius; ++dx) {
      add_pairs(centre, above + dx, below - dx, width, max_step_px, sum, count);
    }
  }
  float* __restrict out = disparity_px.row(target);
  const float* __restrict s = sigma_px.row(target);
  for (std::int32_t x = 0; x < width; ++x) out[x] = s[x] > 0 ? sum[x] / count[x] : 0.0F;
}

}  // namespace ilp
