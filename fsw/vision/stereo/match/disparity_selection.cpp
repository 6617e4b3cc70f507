#include "fsw/vision/stereo/match/disparity_selection.hpp"

#include <algorithm>

#include "fsw/vision/stereo/match/correlation_peak.hpp"

namespace ilp {
namespace {

constexpr std::int16_t no_cost = 32767;
constexpr std::int32_t fit_support_radius = 2;

/// The cheapest of the left pixels that chose the same right one keeps it. Right pixels count from the left end of the
/// range's reach.
void claim(SelectionWorkspace& w, std::int32_t x, std::int32_t padded, const RowWinner& winner) {
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
struct Support {
  std::int32_t before = 0, at = 0, after = 0;
  std::int32_t count = 0;  ///< of pixels

  void take(const std::int16_t* c) {
    before += c[-1];
    at += c[0];
    after += c[1];
    ++count;
  }
  /// The same with the right pixel held instead of the left one.
  void take_from_right(const std::int16_t* c, std::ptrdiff_t padded) {
    before += c[-1 - padded];
    at += c[0];
    after += c[1 + padded];
    ++count;
  }
};

bool chose_about(const SelectionWorkspace& w, std::int32_t column, std::int32_t d) {
  return static_cast<std::uint32_t>(w.best_index[static_cast<std::size_t>(column)] - d + 1) <= 2;
}

/// A correlation that is lopsided when the left pixel is held is lopsided the other way when the right one is: the sum
/// has no such error. False where not all of the correlations are known.
bool support_from_right(const std::int16_t* c, std::ptrdiff_t padded, Support& support) {
  for (std::int32_t step = -fit_support_radius; step <= fit_support_radius; ++step) {
    const std::int16_t* beside = c + step * padded;
    if (beside[-1 - padded] == 0 || beside[1 + padded] == 0) return false;
  }
  for (std::int32_t step = -fit_support_radius; step <= fit_support_radius; ++step) {
    support.take_from_right(c + step * padded, padded);
  }
  return true;
}

/// The usual case of all pixels on both sides; false for any other case.
bool supported_by_all(const SelectionWorkspace& w, const std::int16_t* c, std::ptrdiff_t padded, std::int32_t x,
                      std::int32_t d, Support& support) {
  static_assert(fit_support_radius == 2);
  const int agree = int{chose_about(w, x - 2, d)} & int{chose_about(w, x - 1, d)} & int{chose_about(w, x + 1, d)} &
                    int{chose_about(w, x + 2, d)};
  if (agree == 0 || c[-2 * padded] == 0 || c[-padded] == 0 || c[padded] == 0 || c[2 * padded] == 0) return false;
  for (std::int32_t step = -2; step <= 2; ++step) support.take(c + step * padded);
  return true;
}

Support supported(const SelectionWorkspace& w, const std::int16_t* c, std::ptrdiff_t padded, std::int32_t width,
                  std::int32_t x, std::int32_t d) {
  const auto agrees = [&](std::int32_t step) {
    const std::int32_t beside = x + step;
    if (beside < 0 || beside >= width) return false;
    const auto k = static_cast<std::size_t>(beside);
    if (d < w.first_inner[k] || d > w.last_inner[k]) return false;
    return chose_about(w, beside, d) && c[step * padded] != 0;
  };
  Support support;
  support.take(c);
  bool left = true;
  bool right = true;
  for (std::int32_t step = 1; step <= fit_support_radius; ++step) {
    left = left && agrees(-step);
    right = right && agrees(step);
    if (left) support.take(c - step * padded);
    if (right) support.take(c + step * padded);
  }
  return support;
}

/// The right pixels that the winners of a run choose.
void claim_run(const SearchRun& run, std::int32_t padded, std::int32_t count, const RowWinner* winners,
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

/// Limits of a row's checks, apart from its winners.
struct RowChecks {
  const NccRows& rows;
  std::int32_t y;
  const StereoParams& params;
  const std::int16_t* ncc;
  const RowWinner* winners;
  const float* variance;
  float min_ncc, min_variance;
};

/// Gathers the input of the fits; `fit_at` stays 0 for rejected pixels.
void check_run(const RowChecks& r, const SearchRun& run, SelectionWorkspace& w) {
  const std::int32_t width = r.rows.left.width;
  const std::int32_t padded = r.rows.padded_disparities;
  const std::uint8_t* left_valid = r.rows.left_valid.row(r.y);
  const std::int32_t first_inner = w.first_inner[static_cast<std::size_t>(run.begin)];
  const std::int32_t last_inner = w.last_inner[static_cast<std::size_t>(run.begin)];
  const bool symmetric = r.params.matcher == StereoMatcherChoice::ordered_scanline;
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const std::int32_t d = w.best_index[k];
    w.fit_at[k] = 0;
    // A winner at the end of the range may continue beyond it.
    if (left_valid[x] == 0 || !r.winners[x].unique || d < first_inner || d > last_inner) continue;
    const std::int16_t* c = r.ncc + static_cast<std::ptrdiff_t>(x) * padded + d;
    // Zero is the correlation of pixels that are out of view or masked.
    if (c[0] == 0 || r.variance[x] < r.min_variance) continue;
    if (!has_its_right_pixel(w, x, padded, d, r.params.allow_one_px)) continue;

    Support support;
    const bool inside = x >= run.begin + fit_support_radius && x < run.end - fit_support_radius;
    if (!inside || !supported_by_all(w, c, padded, x, d, support)) {
      support = supported(w, c, padded, width, x, d);
    } else if (symmetric && x > run.begin + fit_support_radius && x + 1 < run.end - fit_support_radius) {
      (void)support_from_right(c, padded, support);
    }
    const auto at = static_cast<float>(support.at);
    if (at < r.min_ncc * static_cast<float>(support.count)) continue;
    w.fit_before[k] = static_cast<float>(support.before);
    w.fit_at[k] = at;
    w.fit_after[k] = static_cast<float>(support.after);
    w.peak_before[k] = c[-1];
    w.peak_at[k] = c[0];
    w.peak_after[k] = c[1];
  }
}

/// Fits a whole row at once, because fitting rejected pixels is cheaper than skipping them.
void fit_row(const SelectionWorkspace& w, const float* __restrict variance, std::int32_t width,
             std::int32_t min_disparity, float damping, float area, float* __restrict disparity_px,
             float* __restrict sigma_px) {
  constexpr float unit = 1.0F / static_cast<float>(ncc_one);
  for (std::int32_t x = 0; x < width; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const CorrelationPeak fit{w.fit_before[k], w.fit_at[k], w.fit_after[k]};
    const CorrelationPeak peak{static_cast<float>(w.peak_before[k]) * unit, static_cast<float>(w.peak_at[k]) * unit,
                               static_cast<float>(w.peak_after[k]) * unit};
    disparity_px[x] = static_cast<float>(min_disparity + w.best_index[k]) + peak_vertex(fit);
    sigma_px[x] = peak_sigma(peak, area * variance[x], damping, area);
  }
  for (std::int32_t x = 0; x < width; ++x) {
    const bool valid = w.fit_at[static_cast<std::size_t>(x)] > 0;
    disparity_px[x] = valid ? disparity_px[x] : 0.0F;
    sigma_px[x] = valid ? sigma_px[x] : 0.0F;
  }
}

}  // namespace

void select_row(const NccRows& rows, std::int32_t y, std::int32_t count, const StereoParams& params,
                const std::int16_t* ncc, const RowWinner* winners, const float* variance, SelectionWorkspace& w,
                float* disparity_px, float* sigma_px) {
  const std::int32_t width = rows.left.width;
  std::fill_n(w.right_best.begin(), width + rows.padded_disparities, no_cost);
  for (const SearchRun& run : rows.search) claim_run(run, rows.padded_disparities, count, winners, w);
  const RowChecks checks{rows,
                         y,
                         params,
                         ncc,
                         winners,
                         variance,
                         static_cast<float>(params.min_ncc * ncc_one),
                         static_cast<float>(params.min_texture_grey * params.min_texture_grey)};
  for (const SearchRun& run : rows.search) check_run(checks, run, w);
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  fit_row(w, variance, width, rows.min_disparity, rows.damping, area, disparity_px, sigma_px);
}

}  // namespace ilp
