#include "fsw/vision/stereo/ordered/ordered_rows.hpp"

#include <algorithm>

namespace ilp {
namespace {

// The costs of both halves of a path are added, and the sum is a word.
constexpr std::int16_t unreachable = 16000;
static_assert(2 * (unreachable + max_ordered_cost) <= 32767 + max_ordered_cost);
constexpr std::int16_t no_path = 32767;

RowLanes every(int value) {
  return RowLanes{} + static_cast<std::int16_t>(value);
}

constexpr int units(int cost) {
  return cost * max_ordered_cost / max_matching_cost;
}

/// Neighbouring windows overlap, so that a chance advantage of one is that of a window's width.
int uniqueness_lead(const StereoParams& params) {
  return max_ordered_cost * params.uniqueness_permille * (2 * params.window_radius + 1) / 1000;
}

/// The rows at work.
struct Rows {
  std::int32_t padded;
  std::int32_t lanes;
  /// Cost of a match of which one pixel is out of view: less than an occlusion, or paths would leave pixels out there.
  std::int16_t unknown;
  RowLanes occlusion;
  RowLanes lead;
  const std::int16_t* ncc[row_lanes];
  RowWinner* winners[row_lanes];
  OrderedWorkspace& w;

  void load_column(std::int32_t x, const SearchRun& run, std::int32_t count) const {
    load_costs(ncc, static_cast<std::ptrdiff_t>(x) * padded + run.first, count, unknown, w.cost.data());
  }
  /// By disparity of the run; the guards are at -1 and behind the last.
  [[nodiscard]] RowLanes* reached(const SearchRun& run) const { return w.reached.data() + 1 + run.first; }

  /// Before the first column every disparity is free.
  void open() const {
    w.reached.front() = w.reached[static_cast<std::size_t>(padded) + 1] = every(unreachable);
    std::fill_n(w.reached.begin() + 1, padded, RowLanes{});
  }
  /// No path passes where the run does not search.
  void close(const SearchRun& run) const {
    std::fill(w.reached.begin(), w.reached.begin() + 1 + run.first, every(unreachable));
    std::fill(w.reached.begin() + 1 + run.first + run.count, w.reached.begin() + padded + 2, every(unreachable));
  }
};

/// A column from the left. Disparities descend, because an occluded right pixel lowers them; an occluded left pixel
/// raises them. `base` is the lowest cost before the column, then after it.
template <typename Count>
[[gnu::always_inline]] inline void step_right(const Rows& rows, const SearchRun& run, Count count, RowLanes* before_out,
                                              RowLanes& base) {
  const RowLanes* cost = rows.w.cost.data();
  RowLanes* reached = rows.reached(run);
  const RowLanes most = every(unreachable), relative = base;
  RowLanes lowest = most, right_occluded = most;
  RowLanes before = reached[count - 1] - relative;
  for (std::int32_t d = count - 1; d >= 0; --d) {
    before_out[d] = before;
    const RowLanes matched = before + cost[d];
    before = reached[d - 1] - relative;
    const RowLanes least = lanes::lower(lanes::lower(matched, before + rows.occlusion), most);
    const RowLanes all = lanes::lower(least, right_occluded);
    reached[d] = all;
    lowest = lanes::lower(lowest, all);
    right_occluded = all + rows.occlusion;
  }
  before_out[-1] = before;
  base = lowest;
}

/// Which match of its left pixel each row's cheapest path takes.
struct ColumnChoice {
  RowLanes cost = every(no_path);      ///< of the cheapest path through any match
  RowLanes index{};                    ///< its disparity, the smallest of several
  RowLanes occluded = every(no_path);  ///< cost of the cheapest path that leaves the left pixel out
};

/// A column from the right: the mirror image.
template <typename Count>
[[gnu::always_inline]] inline ColumnChoice step_left(const Rows& rows, const SearchRun& run, Count count,
                                                     const RowLanes* before, RowLanes& base) {
  const RowLanes* cost = rows.w.cost.data();
  RowLanes* reached = rows.reached(run);
  RowLanes* total = rows.w.total.data();
  const RowLanes most = every(unreachable), relative = base;
  RowLanes lowest = most, right_occluded = most, index{};
  RowLanes after = reached[0] - relative;
  ColumnChoice choice;
  for (std::int32_t d = 0; d < count; ++d) {
    const RowLanes matched = after + cost[d];
    const RowLanes through = before[d] + matched;
    total[d] = through;
    const RowLanes better = through < choice.cost;
    choice.cost = lanes::lower(choice.cost, through);
    choice.index = (choice.index & ~better) | (index & better);
    index += 1;
    choice.occluded = lanes::lower(choice.occluded, before[d - 1] + after);
    after = reached[d + 1] - relative;
    const RowLanes least = lanes::lower(lanes::lower(matched, after + rows.occlusion), most);
    const RowLanes all = lanes::lower(least, right_occluded);
    reached[d] = all;
    lowest = lanes::lower(lowest, all);
    right_occluded = all + rows.occlusion;
  }
  base = lowest;
  choice.occluded += rows.occlusion;
  return choice;
}

/// Rows in which another match than the chosen one and those beside it costs little more.
template <typename Count>
[[gnu::always_inline]] inline RowLanes find_rivals(const RowLanes* total, Count count, const ColumnChoice& choice,
                                                   RowLanes lead) {
  const RowLanes limit = choice.cost + lead;
  RowLanes rivals{};
  RowLanes away = -choice.index;
  for (std::int32_t d = 0; d < count; ++d, away += 1) rivals |= (total[d] < limit) & ((away > 1) | (away < -1));
  return rivals;
}

/// `right` are the right pixels of the last matches. Between paths of equal cost, and where neighbouring runs search
/// different disparities, the choices of two columns may belong to different paths: then the order decides.
template <typename Count>
void choose(const Rows& rows, const SearchRun& run, Count count, std::int32_t x, const ColumnChoice& choice,
            RowLanes& right) {
  const RowLanes rivals = find_rivals(rows.w.total.data(), count, choice, rows.lead);
  const RowLanes target = every(x - run.first) - choice.index;
  const RowLanes matched = (choice.cost <= choice.occluded) & (target < right);
  right = (target & matched) | (right & ~matched);
  for (std::int32_t k = 0; k < rows.lanes; ++k) {
    RowWinner& winner = rows.winners[k][x];
    winner.cost = matched[k] != 0 ? std::int16_t{0} : occluded_cost;
    winner.index = static_cast<std::int16_t>(run.first + choice.index[k]);
    winner.unique = matched[k] != 0 && rivals[k] == 0;
  }
}

}  // namespace

void find_ordered_rows(const SearchRow& search, std::int32_t padded, const StereoParams& params,
                       const std::int16_t* const* ncc, std::int32_t lanes, OrderedWorkspace& workspace,
                       RowWinner* const* winners) {
  Rows rows{padded,
            lanes,
            static_cast<std::int16_t>(units(occlusion_cost) * 3 / 4),
            every(units(occlusion_cost)),
            every(uniqueness_lead(params)),
            {},
            {},
            workspace};
  for (std::int32_t k = 0; k < row_lanes; ++k) {
    const std::int32_t row = std::min(k, lanes - 1);
    rows.ncc[k] = ncc[row];
    rows.winners[k] = winners[row];
  }
  RowLanes base{};
  RowLanes* before = workspace.before.data() + 1;
  rows.open();
  for (const SearchRun& run : search) {
    with_known_count(run.count, [&](auto count) {
      for (std::int32_t x = run.begin; x < run.end; ++x) {
        rows.load_column(x, run, count);
        step_right(rows, run, count, before, base);
        before += count + 1;
        if (x == run.begin) rows.close(run);
      }
    });
  }
  base = RowLanes{};
  RowLanes right = every(no_path);
  rows.open();
  for (std::int32_t i = search.size - 1; i >= 0; --i) {
    const SearchRun& run = search.runs[static_cast<std::size_t>(i)];
    with_known_count(run.count, [&](auto count) {
      for (std::int32_t x = run.end - 1; x >= run.begin; --x) {
        rows.load_column(x, run, count);
        before -= count + 1;
        choose(rows, run, count, x, step_left(rows, run, count, before, base), right);
        if (x == run.end - 1) rows.close(run);
      }
    });
  }
}

}  // namespace ilp
