#include "fsw/vision/stereo/disparity_selection.hpp"

#include <algorithm>

#include "fsw/vision/stereo/correlation_peak.hpp"

namespace ilp {
namespace {

constexpr std::int16_t no_cost = 32767;
constexpr std::int32_t fit_support_radius = 2;

/// Of the left pixels that chose a right one, the cheapest has it. Right pixels count from the left end of what the
/// range reaches.
void claim(SelectionWorkspace& w, std::int32_t x, std::int32_t padded, const PathWinner& winner) {
  const auto target = static_cast<std::size_t>(x + padded - winner.index);
  if (winner.cost >= w.right_best[target]) return;
  w.right_best[target] = winner.cost;
  w.right_index[target] = winner.index;
}

bool has_its_right_pixel(const SelectionWorkspace& w, std::int32_t x, std::int32_t padded, std::int32_t d,
                         bool allow_one_px) {
  const std::int32_t away = w.right_index[static_cast<std::size_t>(x + padded - d)] - d;
  const std::int32_t most = allow_one_px ? 1 : 0;
  return -most <= away && away <= most;
}

/// Sum of correlations around disparity index d over the pixel and those beside it that chose the same disparity or the
/// next: the fit needs more support than the window gives, and path costs would pull it to whole pixels. Beside the
/// edge of what is in view one side has to do: windows there reach out of it, those further inside less.
struct SupportedPeak {
  CorrelationPeak sum;
  float count = 0;  ///< of pixels
};
SupportedPeak supported(const SelectionWorkspace& w, const std::int16_t* ncc, std::int32_t padded, std::int32_t width,
                        std::int32_t x, std::int32_t d) {
  std::int32_t before = 0;
  std::int32_t at = 0;
  std::int32_t after = 0;
  std::int32_t count = 0;
  const auto take = [&](std::int32_t column) {
    const std::int16_t* c = ncc + static_cast<std::ptrdiff_t>(column) * padded + d;
    before += c[-1];
    at += c[0];
    after += c[1];
    ++count;
  };
  const auto agrees = [&](std::int32_t column) {
    if (column < 0 || column >= width) return false;
    const auto k = static_cast<std::size_t>(column);
    if (d < w.first_inner[k] || d > w.last_inner[k]) return false;
    const std::int32_t away = w.best_index[k] - d;
    return away >= -1 && away <= 1 && ncc[static_cast<std::ptrdiff_t>(column) * padded + d] != 0;
  };
  take(x);
  bool left = true;
  bool right = true;
  for (std::int32_t step = 1; step <= fit_support_radius; ++step) {
    left = left && agrees(x - step);
    right = right && agrees(x + step);
    if (left) take(x - step);
    if (right) take(x + step);
  }
  return {{static_cast<float>(before), static_cast<float>(at), static_cast<float>(after)}, static_cast<float>(count)};
}

CorrelationPeak peak_at(const std::int16_t* ncc) {
  constexpr float unit = 1.0F / static_cast<float>(ncc_one);
  return {static_cast<float>(ncc[-1]) * unit, static_cast<float>(ncc[0]) * unit, static_cast<float>(ncc[1]) * unit};
}

/// Which right pixels the winners of a run choose.
void claim_run(const SearchRun& run, std::int32_t padded, std::int32_t count, const PathWinner* winners,
               SelectionWorkspace& w) {
  const std::int32_t searched = std::min(run.count, count - run.first);
  const std::int32_t columns = run.end - run.begin;
  std::fill_n(w.first_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + 1));
  std::fill_n(w.last_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + searched - 2));
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    w.best_index[static_cast<std::size_t>(x)] = winners[x].index;
    claim(w, x, padded, winners[x]);
  }
}

}  // namespace

void select_row(const NccRows& rows, std::int32_t count, const StereoParams& params, const std::int16_t* ncc,
                const PathWinner* winners, const float* variance, SelectionWorkspace& w, float* disparity_px,
                float* sigma_px) {
  const std::int32_t width = rows.left.width;
  const std::int32_t padded = rows.padded_disparities;
  const std::int32_t y = rows.next_row - 1;
  const std::uint8_t* left_valid = rows.left_valid.row(y);
  std::fill_n(w.right_best.begin(), width + padded, no_cost);
  for (const SearchRun& run : rows.search) claim_run(run, padded, count, winners, w);

  const auto min_ncc = static_cast<float>(params.min_ncc * ncc_one);
  const auto min_variance = static_cast<float>(params.min_texture_grey * params.min_texture_grey);
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  for (std::int32_t x = 0; x < width; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const std::int32_t d = w.best_index[k];
    disparity_px[x] = 0;
    sigma_px[x] = 0;
    // A winner at the end of the range may continue beyond it.
    if (left_valid[x] == 0 || !winners[x].unique || d < w.first_inner[k] || d > w.last_inner[k]) continue;
    const std::int16_t* c = ncc + static_cast<std::ptrdiff_t>(x) * padded + d;
    // Zero is the correlation with what is out of view or masked.
    if (c[0] == 0 || variance[x] < min_variance) continue;
    if (!has_its_right_pixel(w, x, padded, d, params.allow_one_px)) continue;

    const SupportedPeak fit = supported(w, ncc, padded, width, x, d);
    if (fit.sum.at < min_ncc * fit.count) continue;
    disparity_px[x] = static_cast<float>(rows.min_disparity + d) + peak_vertex(fit.sum);
    sigma_px[x] = peak_sigma(peak_at(c), area * variance[x], rows.damping, area);
  }
}

}  // namespace ilp
