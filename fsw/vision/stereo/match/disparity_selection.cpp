#include "fsw/vision/stereo/match/disparity_selection.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"
#include "fsw/vision/stereo/match/correlation_peak.hpp"

namespace ilp {
namespace {

constexpr std::int16_t no_cost = 32767;
constexpr std::int32_t fit_support_radius = 2;
/// Of the disparity of the right pixel, which is thus the neighbouring one at most.
constexpr std::int16_t most_away_px = 1;

/// The cheapest of the left pixels that chose the same right one keeps it. Right pixels count from the left end of the
/// range's reach.
void claim(SelectionWorkspace& w, std::int32_t x, std::int32_t padded, const RowWinner& winner) {
  const auto target = static_cast<std::size_t>(x + padded - winner.index);
  if (winner.cost >= w.right_best[target]) return;
  w.right_best[target] = winner.cost;
  w.right_index[target] = winner.index;
}

bool has_its_right_pixel(const SelectionWorkspace& w, std::int32_t x, std::int32_t padded, std::int32_t d) {
  const std::int32_t away = w.right_index[static_cast<std::size_t>(x + padded - d)] - d;
  return static_cast<std::uint32_t>(away + most_away_px) <= std::uint32_t{2 * most_away_px};
}

using PeakWords [[gnu::vector_size(16)]] = std::int16_t;
using PeakSums [[gnu::vector_size(16)]] = std::int32_t;

/// The correlations before, at and after a disparity, and five without a meaning.
[[gnu::always_inline]] inline PeakWords around(const std::int16_t* c) {
  std::uint64_t four;
  std::memcpy(&four, c - 1, sizeof four);
  const lanes::U64 both = {four, 0};
  return reinterpret_cast<PeakWords>(both);
}
/// The first four. The compiler's own conversion takes twice as many instructions.
[[gnu::always_inline]] inline PeakSums widened(PeakWords words) {
  return reinterpret_cast<PeakSums>(__builtin_shufflevector(words, words, 0, 0, 1, 1, 2, 2, 3, 3)) >> 16;
}

/// Sums of correlations around disparity index d over the pixel and those beside it that chose the same disparity or
/// the next: the fit needs more support than the window gives, and path costs would pull it to whole pixels. Beside the
/// edge of what is in view one side has to do: windows there reach out of it, those further inside less.
struct Support {
  PeakSums sums{};         ///< before, at and after the disparity
  std::int32_t count = 0;  ///< of pixels

  void take(const std::int16_t* c) {
    sums += widened(around(c));
    ++count;
  }
  /// The same with the right pixel held instead of the left one.
  void take_from_right(const std::int16_t* c, std::ptrdiff_t padded) {
    sums += PeakSums{c[-1 - padded], c[0], c[1 + padded], 0};
    ++count;
  }
  /// As an element of SelectionWorkspace::fits.
  [[nodiscard]] PeakSums fit() const {
    PeakSums out = sums;
    out[3] = count;
    return out;
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

/// Per column, 0 or 1.
using Flags = std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)>;

/// Whether the two pixels on either side chose about the same disparity and are in the run.
void find_agreeing(const std::int16_t* __restrict index, const SearchRun& run, std::uint8_t* __restrict agreeing) {
  static_assert(fit_support_radius == 2);
  std::fill(agreeing + run.begin, agreeing + run.end, std::uint8_t{0});
  // Indices differ by less than a word holds. Words that are compared with words stay several in a vector.
  const auto about = [](std::int16_t a, std::int16_t b) {
    const auto away = static_cast<std::uint16_t>(a - b + 1);
    return static_cast<std::uint16_t>(away <= std::uint16_t{2} ? 1 : 0);
  };
  for (std::int32_t x = run.begin + 2; x < run.end - 2; ++x) {
    const std::int16_t d = index[x];
    agreeing[x] = static_cast<std::uint8_t>(about(index[x - 2], d) & about(index[x - 1], d) & about(index[x + 1], d) &
                                            about(index[x + 2], d));
  }
}

/// Support of the pixel and all those on both sides, which agree; false where one of them is not in view.
[[gnu::always_inline]] inline bool supported_by_all(const std::int16_t* c, std::ptrdiff_t padded, Support& support) {
  const PeakWords far_left = around(c - 2 * padded), left = around(c - padded), own = around(c),
                  right = around(c + padded), far_right = around(c + 2 * padded);
  const PeakWords unseen = (far_left == 0) | (left == 0) | (own == 0) | (right == 0) | (far_right == 0);
  if (unseen[1] != 0) return false;
  support.sums = widened(far_left) + widened(left) + widened(own) + widened(right) + widened(far_right);
  support.count = 2 * fit_support_radius + 1;
  return true;
}

[[gnu::noinline]] Support supported(const SelectionWorkspace& w, const std::int16_t* c, std::ptrdiff_t padded,
                                    std::int32_t width, std::int32_t x, std::int32_t d) {
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

/// The winners of eight pixels.
struct EightWinners {
  lanes::I16 cost, index, unique;
};
[[gnu::always_inline]] inline EightWinners load_winners(const RowWinner* winners) {
  static_assert(sizeof(RowWinner) == 8 && offsetof(RowWinner, index) == 2 && offsetof(RowWinner, unique) == 4);
  using lanes::I16;
  using lanes::U64;
  const I16 a = lanes::load<I16>(winners), b = lanes::load<I16>(winners + 2), c = lanes::load<I16>(winners + 4),
            e = lanes::load<I16>(winners + 6);
  const auto low = [](I16 v, I16 w) { return __builtin_shufflevector(v, w, 0, 8, 1, 9, 2, 10, 3, 11); };
  const auto high = [](I16 v, I16 w) { return __builtin_shufflevector(v, w, 4, 12, 5, 13, 6, 14, 7, 15); };
  const I16 ab = low(a, b), ab2 = high(a, b), ce = low(c, e), ce2 = high(c, e);
  // Costs and indices of four pixels each, and whether they are unique.
  const auto first = reinterpret_cast<U64>(low(ab, ab2)), second = reinterpret_cast<U64>(low(ce, ce2));
  const auto first_unique = reinterpret_cast<U64>(high(ab, ab2)), second_unique = reinterpret_cast<U64>(high(ce, ce2));
  return {reinterpret_cast<I16>(__builtin_shufflevector(first, second, 0, 2)),
          reinterpret_cast<I16>(__builtin_shufflevector(first, second, 1, 3)),
          reinterpret_cast<I16>(__builtin_shufflevector(first_unique, second_unique, 0, 2)) & std::int16_t{1}};
}

/// The same as claim() for eight pixels from x on with one disparity.
[[gnu::always_inline]] inline void claim_level(SelectionWorkspace& w, std::int32_t x, std::int32_t padded,
                                               std::int32_t index, lanes::I16 cost) {
  const std::ptrdiff_t target = x + padded - index;
  std::int16_t* best = w.right_best.data() + target;
  std::int16_t* best_index = w.right_index.data() + target;
  const lanes::I16 before = lanes::load<lanes::I16>(best);
  const lanes::I16 cheaper = cost < before;
  lanes::store(best, lanes::lower(cost, before));
  const lanes::I16 index_before = lanes::load<lanes::I16>(best_index);
  lanes::store(best_index, cheaper ? lanes::I16{} + static_cast<std::int16_t>(index) : index_before);
}

/// The right pixels that the winners of a run choose.
void claim_run(const SearchRun& run, std::int32_t padded, std::int32_t count, const RowWinner* winners,
               SelectionWorkspace& w, Flags& unique) {
  const std::int32_t searched = std::min(run.count, count - run.first);
  const std::int32_t columns = run.end - run.begin;
  std::fill_n(w.first_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + 1));
  std::fill_n(w.last_inner.begin() + run.begin, columns, static_cast<std::int16_t>(run.first + searched - 2));
  std::int32_t x = run.begin;
  for (; x + lanes::words <= run.end; x += lanes::words) {
    const EightWinners eight = load_winners(winners + x);
    lanes::store(w.best_index.data() + x, eight.index);
    const auto flags = reinterpret_cast<lanes::U64>(lanes::bytes_of_words(eight.unique, eight.unique))[0];
    std::memcpy(unique.data() + x, &flags, sizeof flags);
    const std::int16_t index = winners[x].index;
    if (!lanes::any(eight.index ^ index)) {
      claim_level(w, x, padded, index, eight.cost);
      continue;
    }
    for (std::int32_t i = x; i < x + lanes::words; ++i) claim(w, i, padded, winners[i]);
  }
  for (; x < run.end; ++x) {
    w.best_index[static_cast<std::size_t>(x)] = winners[x].index;
    unique[static_cast<std::size_t>(x)] = winners[x].unique ? 1 : 0;
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
  float min_variance;
};

/// What check_pixel needs, in registers.
struct PixelRule {
  const std::int16_t* ncc;
  std::ptrdiff_t padded;
  std::int32_t width;
  bool holds_right;  ///< adds correlations in which the right pixel is held, for columns from first to last
  std::int32_t first, last;
};

/// Gathers the input of the fit of pixel x, whose window, uniqueness and place in the range are good. `agreeing`: so
/// are its neighbours.
[[gnu::always_inline]] inline void check_pixel(const PixelRule& r, std::int32_t x, bool agreeing,
                                               SelectionWorkspace& w) {
  const auto k = static_cast<std::size_t>(x);
  const std::int32_t d = w.best_index[k];
  const std::int16_t* c = r.ncc + x * r.padded + d;
  if (!has_its_right_pixel(w, x, static_cast<std::int32_t>(r.padded), d)) return;
  Support support;
  if (!agreeing || !supported_by_all(c, r.padded, support)) {
    // Zero is the correlation of pixels that are out of view or masked.
    if (c[0] == 0) return;
    support = supported(w, c, r.padded, r.width, x, d);
  } else if (r.holds_right && x >= r.first && x <= r.last) {
    (void)support_from_right(c, r.padded, support);
  }
  const PeakSums fit = support.fit();
  const PeakWords peak = around(c);
  std::memcpy(w.fits.data() + 4 * k, &fit, sizeof fit);
  std::memcpy(w.peaks.data() + 4 * k, &peak, sizeof(std::int16_t) * 4);
}

constexpr std::int32_t level_columns = lanes::words;

/// The correlations of a group of pixels and those beside it, from one before the group's lowest disparity on.
struct LevelWindow {
  static_assert(fit_support_radius == 2);
  static constexpr std::int32_t columns = level_columns + 2 * fit_support_radius;
  PeakWords column[columns];

  /// `c`: of the first column. The result has bits in the disparities that are out of view in any column.
  [[gnu::always_inline]] PeakWords load(const std::int16_t* c, std::ptrdiff_t padded) {
    PeakWords unseen{};
#pragma GCC unroll 16
    for (std::int32_t i = 0; i < columns; ++i) {
      column[i] = around(c + i * padded);
      unseen |= column[i] == 0;
    }
    return unseen;
  }
  /// Calls `use(i, sums)` with the sums over the support of each pixel of the group, in the first three elements or in
  /// the last three.
  template <typename Use>
  [[gnu::always_inline]] void slide(Use use) const {
    PeakSums sums = widened(column[0]) + widened(column[1]) + widened(column[2]) + widened(column[3]);
#pragma GCC unroll 8
    for (std::int32_t i = 0; i < level_columns; ++i) {
      sums += widened(column[i + 4]);
      use(i, sums);
      sums -= widened(column[i]);
    }
  }
};

/// The same for level_columns pixels from x on, all of them good, on ground that is nearly level: they and their
/// neighbours chose one disparity or the next, so that one window slides over their correlations. False, and nothing is
/// done, elsewhere.
[[gnu::always_inline]] inline bool check_level_pixels(const PixelRule& r, std::int32_t x, SelectionWorkspace& w) {
  using lanes::I16;
  const std::int16_t* index = w.best_index.data() + x;
  const I16 before = lanes::load<I16>(index - 2), after = lanes::load<I16>(index + 2);
  constexpr std::int16_t more_than_one = ~1;
  std::int16_t lowest = index[0];
  if (lanes::any(((before - lowest) | (after - lowest)) & more_than_one)) {
    --lowest;
    if (lanes::any(((before - lowest) | (after - lowest)) & more_than_one)) return false;
  }
  const bool is_level = !lanes::any((before - lowest) | (after - lowest));
  const I16 own = lanes::load<I16>(index);
  const std::int16_t* right = w.right_index.data() + x + r.padded - lowest;
  const I16 right_index = own > lowest ? lanes::load<I16>(right - 1) : lanes::load<I16>(right);
  const I16 away = right_index - own;
  if (lanes::any((away > most_away_px) | (-away > most_away_px))) return false;
  const std::int16_t* c = r.ncc + (x - fit_support_radius) * r.padded + lowest;
  LevelWindow window;
  const PeakWords unseen = window.load(c, r.padded);
  if (unseen[1] != 0 || (!is_level && unseen[2] != 0)) return false;
  constexpr PeakSums sums_only = {-1, -1, -1, 0};
  constexpr PeakSums count = {0, 0, 0, 2 * fit_support_radius + 1};
  std::int32_t* fits = w.fits.data() + std::ptrdiff_t{4} * x;
  std::int16_t* peaks = w.peaks.data() + std::ptrdiff_t{4} * x;
  if (is_level) {
    window.slide([&](std::int32_t i, PeakSums sums) __attribute__((always_inline)) {
      const PeakSums fit = (sums & sums_only) | count;
      std::memcpy(fits + std::ptrdiff_t{4} * i, &fit, sizeof fit);
      std::memcpy(peaks + std::ptrdiff_t{4} * i, &window.column[i + 2], sizeof(std::int16_t) * 4);
    });
    return true;
  }
  const std::int16_t* own_peak = c + fit_support_radius * r.padded - 1;
  window.slide([&](std::int32_t i, PeakSums sums) __attribute__((always_inline)) {
    const std::int32_t next = index[i] - lowest;
    const PeakSums of_next = __builtin_shufflevector(sums, sums, 1, 2, 3, 0);
    const PeakSums fit = ((PeakSums{} + next > 0 ? of_next : sums) & sums_only) | count;
    std::memcpy(fits + std::ptrdiff_t{4} * i, &fit, sizeof fit);
    std::memcpy(peaks + std::ptrdiff_t{4} * i, own_peak + i * r.padded + next, sizeof(std::int16_t) * 4);
  });
  return true;
}

/// Checks the pixels of a run that are good.
void check_good_pixels(const PixelRule& r, const SearchRun& run, const std::uint8_t* good, const std::uint8_t* agreeing,
                       SelectionWorkspace& w) {
  constexpr std::uint64_t all = 0x0101010101010101;
  static_assert(level_columns == sizeof all);
  // The first group ends where a window of the support fits into the run.
  for (std::int32_t x = run.begin, end = run.begin + fit_support_radius; x < run.end; end += level_columns) {
    end = std::min(end, run.end);
    if (end - x == level_columns) {
      std::uint64_t group;
      std::memcpy(&group, good + x, sizeof group);
      const bool is_level =
          group == all && !r.holds_right && end + fit_support_radius <= run.end && check_level_pixels(r, x, w);
      if (group == 0 || is_level) x = end;
    }
    for (; x < end; ++x) {
      if (good[x] != 0) check_pixel(r, x, agreeing[x] != 0, w);
    }
  }
}

/// Gathers the input of the fits, which stay 0 for rejected pixels.
void check_run(const RowChecks& r, const SearchRun& run, const Flags& unique, SelectionWorkspace& w) {
  std::fill(w.fits.begin() + std::ptrdiff_t{4} * run.begin, w.fits.begin() + std::ptrdiff_t{4} * run.end, 0);
  Flags agreeing, good;
  find_agreeing(w.best_index.data(), run, agreeing.data());
  // A winner at the end of the range may continue beyond it.
  const std::uint8_t* __restrict valid = r.rows.left_valid.row(r.y);
  const std::uint8_t* __restrict is_unique = unique.data();
  const std::int16_t* __restrict index = w.best_index.data();
  const float* __restrict variance = r.variance;
  const std::int16_t first = w.first_inner[static_cast<std::size_t>(run.begin)];
  const std::int16_t last = w.last_inner[static_cast<std::size_t>(run.begin)];
  const float least = r.min_variance;
  std::uint8_t* __restrict out = good.data();
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    out[x] = static_cast<std::uint8_t>(static_cast<int>(valid[x] != 0) & static_cast<int>(is_unique[x] != 0) &
                                       static_cast<int>(index[x] >= first) & static_cast<int>(index[x] <= last) &
                                       static_cast<int>(!(variance[x] < least)));
  }
  const PixelRule rule{r.ncc,
                       r.rows.padded_disparities,
                       r.rows.left.width,
                       r.params.matcher == StereoMatcherChoice::ordered_scanline,
                       run.begin + fit_support_radius + 1,
                       run.end - fit_support_radius - 2};
  check_good_pixels(rule, run, out, agreeing.data(), w);
}

constexpr std::int32_t fit_chunk = 64;
/// Fits and peaks of some columns, each number in a row of its own.
struct FitChunk {
  using Row = std::array<float, static_cast<std::size_t>(fit_chunk)>;
  Row before, at, after, count;
  Row peak_before, peak_at, peak_after;
};

/// Numbers 0 to 2 or 3 of four elements, as float.
template <typename Load>
[[gnu::always_inline]] inline void separate(const Load& load, float* first, float* second, float* third,
                                            float* fourth) {
  using Floats [[gnu::vector_size(16)]] = float;
  const PeakSums a = load(0), b = load(1), c = load(2), e = load(3);
  const PeakSums ab = __builtin_shufflevector(a, b, 0, 4, 1, 5), ce = __builtin_shufflevector(c, e, 0, 4, 1, 5);
  const PeakSums ab2 = __builtin_shufflevector(a, b, 2, 6, 3, 7), ce2 = __builtin_shufflevector(c, e, 2, 6, 3, 7);
  const auto store = [](PeakSums v, float* to) {
    const Floats converted = __builtin_convertvector(v, Floats);
    std::memcpy(to, &converted, sizeof converted);
  };
  store(__builtin_shufflevector(ab, ce, 0, 1, 4, 5), first);
  store(__builtin_shufflevector(ab, ce, 2, 3, 6, 7), second);
  store(__builtin_shufflevector(ab2, ce2, 0, 1, 4, 5), third);
  if (fourth != nullptr) store(__builtin_shufflevector(ab2, ce2, 2, 3, 6, 7), fourth);
}

/// `count` columns from `first`, and those that fill the last four.
void gather(const SelectionWorkspace& w, std::int32_t first, std::int32_t count, FitChunk& out) {
  static_assert(limits::max_rectified_width % 4 == 0 && fit_chunk % 4 == 0);
  for (std::int32_t i = 0; i < count; i += 4) {
    const auto k = static_cast<std::size_t>(i);
    const std::int32_t* sums = w.fits.data() + std::ptrdiff_t{4} * (first + i);
    const std::int16_t* own = w.peaks.data() + std::ptrdiff_t{4} * (first + i);
    const auto sums_of = [sums](int n) {
      PeakSums v;
      std::memcpy(&v, sums + std::ptrdiff_t{4} * n, sizeof v);
      return v;
    };
    const auto own_of = [own](int n) { return widened(around(own + std::ptrdiff_t{4} * n + 1)); };
    separate(sums_of, &out.before[k], &out.at[k], &out.after[k], &out.count[k]);
    separate(own_of, &out.peak_before[k], &out.peak_at[k], &out.peak_after[k], nullptr);
  }
}

struct FitRule {
  float min_disparity, damping, area, min_ncc;
};

void fit_columns(const FitChunk& c, const std::int16_t* __restrict index, const float* __restrict variance,
                 std::int32_t count, const FitRule& rule, float* __restrict disparity_px, float* __restrict sigma_px) {
  constexpr float unit = 1.0F / static_cast<float>(ncc_one);
  const FitRule r = rule;
  for (std::int32_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const CorrelationPeak fit{c.before[k], c.at[k], c.after[k]};
    const CorrelationPeak peak{c.peak_before[k] * unit, c.peak_at[k] * unit, c.peak_after[k] * unit};
    disparity_px[i] = r.min_disparity + static_cast<float>(index[i]) + peak_vertex(fit);
    sigma_px[i] = peak_sigma(peak, r.area * variance[i], r.damping, r.area);
  }
  for (std::int32_t i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const bool valid = static_cast<int>(c.at[k] > 0) & static_cast<int>(c.at[k] >= r.min_ncc * c.count[k]);
    disparity_px[i] = valid ? disparity_px[i] : 0.0F;
    sigma_px[i] = valid ? sigma_px[i] : 0.0F;
  }
}

/// Fits whole rows, because fitting rejected pixels is cheaper than skipping them.
void fit_row(const SelectionWorkspace& w, const float* variance, std::int32_t width, const FitRule& rule,
             float* disparity_px, float* sigma_px) {
  FitChunk chunk;
  for (std::int32_t first = 0; first < width; first += fit_chunk) {
    const std::int32_t count = std::min(width - first, fit_chunk);
    gather(w, first, count, chunk);
    fit_columns(chunk, w.best_index.data() + first, variance + first, count, rule, disparity_px + first,
                sigma_px + first);
  }
}

void select(const NccRows& rows, std::int32_t y, std::int32_t count, const StereoParams& params,
            const std::int16_t* ncc, const RowWinner* winners, const float* variance, SelectionWorkspace& w,
            float* disparity_px, float* sigma_px) {
  const std::int32_t width = rows.left.width;
  std::fill_n(w.right_best.begin(), width + rows.padded_disparities, no_cost);
  Flags unique;
  for (const SearchRun& run : rows.search) claim_run(run, rows.padded_disparities, count, winners, w, unique);
  const RowChecks checks{
      rows, y, params, ncc, winners, variance, static_cast<float>(params.min_texture_grey * params.min_texture_grey)};
  for (const SearchRun& run : rows.search) check_run(checks, run, unique, w);
  const auto area = static_cast<float>((2 * rows.radius + 1) * (2 * rows.radius + 1));
  const FitRule rule{static_cast<float>(rows.min_disparity), rows.damping, area,
                     static_cast<float>(params.min_ncc * ncc_one)};
  fit_row(w, variance, width, rule, disparity_px, sigma_px);
}

}  // namespace

void select_row(const NccRows& rows, std::int32_t y, std::int32_t count, const StereoParams& params,
                const std::int16_t* ncc, const RowWinner* winners, const float* variance, SelectionWorkspace& w,
                float* disparity_px, float* sigma_px) {
  with_widest_vectors([&] { select(rows, y, count, params, ncc, winners, variance, w, disparity_px, sigma_px); });
}

}  // namespace ilp
