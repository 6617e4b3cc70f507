#include "fsw/vision/stereo/disparity_selection.hpp"

#include <algorithm>

#include "fsw/vision/stereo/correlation_peak.hpp"

namespace ilp {
namespace {

constexpr std::int16_t no_cost = 32767;
constexpr int full_cost = aggregated_paths * max_matching_cost;
// Higher than any sum of five paths, and still a key.
constexpr std::int16_t excluded_cost = max_path_sum + 1;
constexpr std::int32_t fit_support_radius = 2;
struct Winner {
  std::int16_t cost = no_cost;
  std::int16_t index = 0;
  std::int16_t rival = no_cost;  ///< lowest cost of the disparities not within one of the winner
};

// Disparities are taken in blocks of key_lanes. A key holds a cost and the number of its block, so that a minimum
// carries its place.
constexpr std::int32_t key_lanes = 8;
constexpr int block_bits = 5;
static_assert((excluded_cost << block_bits) + (1 << block_bits) <= no_cost);
static_assert(max_padded_disparities / key_lanes <= 1 << block_bits);
static_assert(disparity_block % key_lanes == 0);

std::int16_t lowest_cost(const std::int16_t* __restrict keys, std::int32_t lanes) {
  std::int16_t lowest = no_cost;
  for (std::int32_t lane = 0; lane < lanes; ++lane) lowest = std::min(lowest, keys[lane]);
  return static_cast<std::int16_t>(lowest >> block_bits);
}

/// The smallest disparity whose key has this cost; all disparities come out by lane.
std::int16_t index_of(const std::int16_t* __restrict keys, std::int32_t lanes, std::int16_t cost,
                      std::int16_t* __restrict disparity) {
  constexpr std::int16_t block_mask = (1 << block_bits) - 1;
  std::int16_t lane_index = 0;
  std::int16_t index = no_cost;
  for (std::int32_t lane = 0; lane < lanes; ++lane) {
    const auto d = static_cast<std::int16_t>((keys[lane] & block_mask) * key_lanes + lane_index);
    const auto excess = static_cast<std::int16_t>((keys[lane] >> block_bits) - cost);
    // Anything above the lowest cost is pushed out of reach; disparities have eight bits.
    const auto candidate = static_cast<std::int16_t>(d + std::min<std::int16_t>(excess, 1) * max_padded_disparities);
    index = std::min(index, candidate);
    disparity[lane] = d;
    ++lane_index;
  }
  return index;
}

std::int16_t rival_cost(const std::int16_t* __restrict first, const std::int16_t* __restrict second,
                        const std::int16_t* __restrict disparity, std::int32_t lanes, std::int16_t index) {
  std::int16_t rival = no_cost;
  for (std::int32_t lane = 0; lane < lanes; ++lane) {
    const auto distance = static_cast<std::int16_t>(disparity[lane] - index);
    // 0 within one disparity of the winner, 1 beyond: no branch, so that the loop becomes vectors.
    const std::int16_t beyond = std::min<std::int16_t>(static_cast<std::int16_t>((distance * distance) >> 1), 1);
    const auto key = static_cast<std::int16_t>(second[lane] + beyond * (first[lane] - second[lane]));
    rival = std::min(rival, key);
  }
  return static_cast<std::int16_t>(rival >> block_bits);
}

/// One pass over the disparities: the two lowest keys of every lane, then the lanes against each other.
Winner find_winner(const std::int16_t* __restrict sums, std::int32_t padded, std::int32_t lanes) {
  alignas(64) std::int16_t first[key_lanes];
  alignas(64) std::int16_t second[key_lanes];
  alignas(64) std::int16_t disparity[key_lanes];
  for (std::int32_t lane = 0; lane < lanes; ++lane) {
    first[lane] = static_cast<std::int16_t>(sums[lane] << block_bits);
    second[lane] = no_cost;
  }
  std::int16_t block = 0;
  for (std::int32_t d = key_lanes; d < padded; d += key_lanes) {
    const std::int16_t* __restrict s = sums + d;
    ++block;
    for (std::int32_t lane = 0; lane < lanes; ++lane) {
      const auto key = static_cast<std::int16_t>((s[lane] << block_bits) + block);
      second[lane] = std::min(second[lane], std::max(first[lane], key));
      first[lane] = std::min(first[lane], key);
    }
  }
  const std::int16_t cost = lowest_cost(first, lanes);
  const std::int16_t index = index_of(first, lanes, cost, disparity);
  return {cost, index, rival_cost(first, second, disparity, lanes, index)};
}

/// Of the left pixels that chose a right one, the cheapest has it. Right pixels count from the left end of what the
/// range reaches.
void claim(SelectionWorkspace& w, std::int32_t x, std::int32_t padded, const Winner& winner) {
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

/// Winners of a run's pixels, and which right pixels they choose.
void select_run(const SearchRun& run, std::int32_t padded, std::int32_t count, const StereoParams& params,
                std::int16_t* sums, SelectionWorkspace& w) {
  // Always key_lanes, but compilers unroll a short loop of known length instead of vectorising it.
  const std::int32_t lanes = std::min(padded, key_lanes);
  const std::int32_t searched = std::min(run.count, count - run.first);
  const std::int32_t columns = run.end - run.begin;
  std::fill_n(w.first_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + 1));
  std::fill_n(w.last_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + searched - 2));
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    std::int16_t* s = sums + static_cast<std::ptrdiff_t>(x) * padded + run.first;
    std::fill(s + searched, s + run.count, excluded_cost);
    Winner winner = find_winner(s, run.count, lanes);
    winner.index = static_cast<std::int16_t>(winner.index + run.first);
    const auto k = static_cast<std::size_t>(x);
    w.best_index[k] = winner.index;
    w.unique[k] = (winner.rival - winner.cost) * 1000 >= full_cost * params.uniqueness_permille ? 1 : 0;
    claim(w, x, padded, winner);
  }
}

}  // namespace

void select_row(const NccRows& rows, std::int32_t count, const StereoParams& params, const std::int16_t* ncc,
                std::int16_t* sums, const float* variance, SelectionWorkspace& w, float* disparity_px,
                float* sigma_px) {
  const std::int32_t width = rows.left.width;
  const std::int32_t padded = rows.padded_disparities;
  const std::int32_t y = rows.next_row - 1;
  const std::uint8_t* left_valid = rows.left_valid.row(y);
  std::fill_n(w.right_best.begin(), width + padded, no_cost);
  for (const SearchRun& run : rows.search) select_run(run, padded, count, params, sums, w);

  const auto min_ncc = static_cast<float>(params.min_ncc * ncc_one);
  const auto min_variance = static_cast<float>(params.min_texture_grey * params.min_texture_grey);
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  for (std::int32_t x = 0; x < width; ++x) {
    const auto k = static_cast<std::size_t>(x);
    const std::int32_t d = w.best_index[k];
    disparity_px[x] = 0;
    sigma_px[x] = 0;
    // A winner at the end of the range may continue beyond it.
    if (left_valid[x] == 0 || w.unique[k] == 0 || d < w.first_inner[k] || d > w.last_inner[k]) continue;
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
