#include "fsw/vision/stereo/semi_global/path_aggregation.hpp"

#include <algorithm>

#include "fsw/vision/stereo/cost/lanes.hpp"

namespace ilp {
namespace {

using lanes::I16;
using lanes::U8;
static_assert(disparity_block == lanes::bytes && path_guard >= 1);

enum Path : int { from_left, from_above_left, from_above, from_above_right, from_right };

/// The values that a path takes over from its previous pixel.
struct Behind {
  const std::uint8_t* costs;
  U8 lowest;
  U8 jump;  ///< the lowest and a large step
};

/// One step of a path at 16 disparities.
[[gnu::always_inline]] inline U8 advance(U8 cost, const Behind& behind, std::int32_t d, U8 small_step) {
  const std::uint8_t* p = behind.costs + d;
  const U8 near = lanes::lower(lanes::load<U8>(p - 1), lanes::load<U8>(p + 1)) + small_step;
  const U8 best = lanes::lower(lanes::lower(lanes::load<U8>(p), behind.jump), near);
  return cost + (best - behind.lowest);
}

// The lowest previous cost may be of a disparity that is not searched here. Then all costs are higher than this, and
// this value can be subtracted instead.
constexpr std::uint8_t max_lowest = 255 - max_large_step;
static_assert(max_lowest >= max_matching_cost);

U8 every(int value) {
  return U8{} + static_cast<std::uint8_t>(value);
}

// The sums of a block begin with the even disparities.
constexpr std::int32_t place_of(std::int32_t d) {
  return (d & ~(disparity_block - 1)) + (d & 1) * lanes::words + ((d & (disparity_block - 1)) >> 1);
}

// A key holds a sum and its disparity in a group, so that the lowest key gives both.
constexpr std::int32_t key_group = 64;
constexpr int key_bits = 6;
static_assert(excluded_sum < 1 << (16 - key_bits));
constexpr I16 even_places = {0, 2, 4, 6, 8, 10, 12, 14};
constexpr std::int16_t lowest_possible_key = -32768;

/// Lowest key of up to key_group disparities.
[[gnu::always_inline]] inline std::int32_t lowest_key(const std::int16_t* sum, std::int32_t count) {
  I16 lowest = I16{} + std::int16_t{32767};
  I16 offset = even_places + lowest_possible_key;
  for (std::int32_t d = 0; d < count; d += disparity_block) {
    // The sum's lowest bits are zero, so that an exclusive or replaces the addition without overflow.
    lowest = lanes::lower(lowest, (lanes::load<I16>(sum + d) << key_bits) ^ offset);
    lowest = lanes::lower(lowest, (lanes::load<I16>(sum + d + lanes::words) << key_bits) ^ (offset + std::int16_t{1}));
    offset += std::int16_t{disparity_block};
  }
  return lanes::lowest_word(lowest) - lowest_possible_key;
}

/// Whether any disparity not within one of `index` has a sum below `limit`.
[[gnu::always_inline]] inline bool has_rival(const std::int16_t* sum, std::int32_t count, std::int16_t index,
                                             std::int16_t limit) {
  const I16 one = I16{} + std::int16_t{1};
  const I16 minus_one = -one;
  I16 rivals{};
  I16 away = even_places - index;
  for (std::int32_t d = 0; d < count; d += disparity_block) {
    const I16 away_odd = away + std::int16_t{1};
    rivals |= (lanes::load<I16>(sum + d) < limit) & ((away > one) | (away < minus_one));
    rivals |= (lanes::load<I16>(sum + d + lanes::words) < limit) & ((away_odd > one) | (away_odd < minus_one));
    away += std::int16_t{disparity_block};
  }
  return lanes::any(rivals);
}

/// The lowest sum, and whether any disparity not within one of it is less than `lead` above.
[[gnu::always_inline]] inline RowWinner find_winner(const std::int16_t* sum, std::int32_t count, std::int32_t lead) {
  std::int32_t cost = excluded_sum;
  std::int32_t index = 0;
  for (std::int32_t group = 0; group < count; group += key_group) {
    const std::int32_t key = lowest_key(sum + group, std::min(count - group, key_group));
    if ((key >> key_bits) >= cost) continue;
    cost = key >> key_bits;
    index = group + (key & (key_group - 1));
  }
  const auto place = static_cast<std::int16_t>(index);
  return {static_cast<std::int16_t>(cost), place,
          !has_rival(sum, count, place, static_cast<std::int16_t>(cost + lead))};
}

/// The state before the first row: zero costs between guards.
void clear(std::uint8_t* costs, std::int32_t columns, std::int32_t padded, std::uint8_t guard) {
  const std::int32_t stride = padded + path_guard;
  std::fill_n(costs, static_cast<std::ptrdiff_t>(columns) * stride + path_guard, guard);
  for (std::int32_t x = 0; x < columns; ++x)
    std::fill_n(costs + path_guard + static_cast<std::ptrdiff_t>(x) * stride, padded, std::uint8_t{0});
}

void find_contrast(const std::uint8_t* __restrict grey, const std::uint8_t* __restrict other, std::int32_t count,
                   std::uint8_t* __restrict contrast) {
  for (std::int32_t x = 0; x < count; ++x) {
    contrast[x] = static_cast<std::uint8_t>(std::max(grey[x], other[x]) - std::min(grey[x], other[x]));
  }
}

/// Contrast is zero for paths that begin at the border.
void find_contrasts(GrayView left, std::int32_t y, PathWorkspace& w) {
  const std::int32_t last = left.width - 1;
  const std::uint8_t* grey = left.row(y);
  const std::uint8_t* above = left.row(std::max(y - 1, 0));
  find_contrast(grey + 1, grey, last, w.contrast[from_left].data() + 1);
  find_contrast(grey + 1, above, last, w.contrast[from_above_left].data() + 1);
  find_contrast(grey, above, last + 1, w.contrast[from_above].data());
  find_contrast(grey, above + 1, last, w.contrast[from_above_right].data());
  find_contrast(grey, grey + 1, last, w.contrast[from_right].data());
  w.contrast[from_left][0] = w.contrast[from_above_left][0] = 0;
  w.contrast[from_above_right][static_cast<std::size_t>(last)] =
      w.contrast[from_right][static_cast<std::size_t>(last)] = 0;
}

/// A row and all inputs of a step.
struct RowPaths {
  std::int32_t y;
  std::int32_t padded;
  const PathPenalties& penalties;
  const std::uint8_t* cost;
  PathWorkspace& w;

  [[nodiscard]] U8 large_step(Path path, std::int32_t x) const {
    return lanes::load<U8>(penalties.large_step.data() +
                           std::ptrdiff_t{w.contrast[path][static_cast<std::size_t>(x)]} * lanes::bytes);
  }
  [[nodiscard]] std::uint8_t guard() const { return static_cast<std::uint8_t>(255 - penalties.small_step); }
  /// The place of the path along the row at column x; disparities outside the run become guards.
  [[nodiscard]] std::uint8_t* along(std::int32_t x, bool first_of_run) const {
    auto& row = w.along[x & 1];
    if (first_of_run) std::fill_n(row.data(), padded + 2 * path_guard, guard());
    return row.data() + path_guard;
  }
};

/// End of a path along the row.
struct PathEnd {
  const std::uint8_t* costs;
  U8 lowest;
};

template <typename Count>
PathEnd aggregate_forward(const RowPaths r, const SearchRun run, Count count, const PathEnd& behind) {
  const std::int32_t stride = r.padded + path_guard;
  const U8 small_step = every(r.penalties.small_step);
  const PathRow* previous = r.w.from_above[(r.y & 1) ^ 1];
  PathRow* current = r.w.from_above[r.y & 1];
  const std::uint8_t* lowest_above = r.w.lowest[(r.y & 1) ^ 1].data();
  std::uint8_t* lowest_here = r.w.lowest[r.y & 1].data();
  PathEnd end = behind;
  for (std::int32_t x = run.begin; x < run.end; ++x) {
    const std::uint8_t* cost = r.cost + static_cast<std::ptrdiff_t>(x) * r.padded + run.first;
    std::int16_t* sum = r.w.sum.data() + static_cast<std::ptrdiff_t>(x) * r.padded + run.first;
    const std::ptrdiff_t here = path_guard + static_cast<std::ptrdiff_t>(x + 1) * stride + run.first;
    std::uint8_t* along = r.along(x, x < run.begin + 2);
    const U8 lowest0 = lanes::spread<from_above_left>(lanes::load<U8>(lowest_above + std::ptrdiff_t{x} * lanes::bytes));
    const U8 lowest1 = lanes::spread<from_above>(lanes::load<U8>(lowest_above + std::ptrdiff_t{x + 1} * lanes::bytes));
    const U8 lowest2 =
        lanes::spread<from_above_right>(lanes::load<U8>(lowest_above + std::ptrdiff_t{x + 2} * lanes::bytes));
    const Behind left{end.costs + run.first, end.lowest, end.lowest + r.large_step(from_left, x)};
    const Behind above0{previous[0].costs.data() + here - stride, lowest0, lowest0 + r.large_step(from_above_left, x)};
    const Behind above1{previous[1].costs.data() + here, lowest1, lowest1 + r.large_step(from_above, x)};
    const Behind above2{previous[2].costs.data() + here + stride, lowest2, lowest2 + r.large_step(from_above_right, x)};
    U8 lowest_a = every(255), lowest_b = lowest_a, lowest_c = lowest_a, lowest_e = lowest_a;
    for (std::int32_t d = 0; d < count; d += disparity_block) {
      const U8 c = lanes::load<U8>(cost + d);
      const U8 a = advance(c, left, d, small_step);
      const U8 b = advance(c, above0, d, small_step);
      const U8 m = advance(c, above1, d, small_step);
      const U8 e = advance(c, above2, d, small_step);
      lanes::store(along + run.first + d, a);
      lanes::store(current[0].costs.data() + here + d, b);
      lanes::store(current[1].costs.data() + here + d, m);
      lanes::store(current[2].costs.data() + here + d, e);
      lowest_a = lanes::lower(lowest_a, a);
      lowest_b = lanes::lower(lowest_b, b);
      lowest_c = lanes::lower(lowest_c, m);
      lowest_e = lanes::lower(lowest_e, e);
      lanes::store(sum + d, lanes::even_bytes(a) + lanes::even_bytes(b) + lanes::even_bytes(m) + lanes::even_bytes(e));
      lanes::store(sum + d + lanes::words,
                   lanes::odd_bytes(a) + lanes::odd_bytes(b) + lanes::odd_bytes(m) + lanes::odd_bytes(e));
    }
    const U8 lowest = lanes::lower(lanes::lowest_of_each(lowest_a, lowest_b, lowest_c, lowest_e), every(max_lowest));
    lanes::store(lowest_here + std::ptrdiff_t{x + 1} * lanes::bytes, lowest);
    end = {along, lanes::spread<from_left>(lowest)};
  }
  return end;
}

struct WinnerRule {
  std::int32_t searched;  ///< disparities of the run; those beyond are padding
  std::int32_t lead;
};

template <typename Count>
PathEnd aggregate_backward(const RowPaths r, const SearchRun run, Count count, const WinnerRule rule,
                           const PathEnd& behind, RowWinner* winners) {
  const U8 small_step = every(r.penalties.small_step);
  PathEnd end = behind;
  for (std::int32_t x = run.end - 1; x >= run.begin; --x) {
    const std::ptrdiff_t entry = static_cast<std::ptrdiff_t>(x) * r.padded + run.first;
    const std::uint8_t* cost = r.cost + entry;
    std::int16_t* sum = r.w.sum.data() + entry;
    std::uint8_t* along = r.along(x, x >= run.end - 2);
    const Behind right{end.costs + run.first, end.lowest, end.lowest + r.large_step(from_right, x)};
    U8 lowest = every(max_lowest);
    for (std::int32_t d = 0; d < count; d += disparity_block) {
      const U8 a = advance(lanes::load<U8>(cost + d), right, d, small_step);
      lanes::store(along + run.first + d, a);
      lowest = lanes::lower(lowest, a);
      lanes::store(sum + d, lanes::load<I16>(sum + d) + lanes::even_bytes(a));
      lanes::store(sum + d + lanes::words, lanes::load<I16>(sum + d + lanes::words) + lanes::odd_bytes(a));
    }
    end = {along, lanes::lowest_everywhere(lowest)};
    for (std::int32_t d = rule.searched; d < count; ++d) sum[place_of(d)] = excluded_sum;
    RowWinner winner = find_winner(sum, count, rule.lead);
    winner.index = static_cast<std::int16_t>(winner.index + run.first);
    winners[x] = winner;
  }
  return end;
}

void start(std::int32_t width, std::int32_t padded, std::uint8_t guard, PathWorkspace& w) {
  for (auto& parity : w.from_above) {
    for (PathRow& row : parity) clear(row.costs.data(), width + 2, padded, guard);
  }
  for (auto& lowest : w.lowest) std::fill_n(lowest.data(), (width + 2) * lanes::bytes, std::uint8_t{0});
  clear(w.zero.data(), 1, padded, guard);
}

}  // namespace

PathPenalties make_path_penalties(const StereoParams& params) {
  PathPenalties penalties;
  penalties.small_step = std::clamp(params.small_step_penalty, 0, max_small_step);
  const int most = std::clamp(params.large_step_penalty, penalties.small_step, max_large_step);
  const int least = std::clamp(params.min_large_step_penalty, penalties.small_step, most);
  for (int grey = 0; grey < 256; ++grey) {
    // Inverse to the gradient beyond edge_grey, as a depth edge is usually an image edge.
    const int penalty = grey <= params.edge_grey ? most : most * params.edge_grey / grey;
    std::fill_n(penalties.large_step.begin() + std::ptrdiff_t{grey} * lanes::bytes, lanes::bytes,
                static_cast<std::uint8_t>(std::max(least, penalty)));
  }
  return penalties;
}

void aggregate_row(GrayView left, std::int32_t y, const SearchRow& search, std::int32_t padded,
                   std::int32_t disparities, std::int32_t lead, const PathPenalties& penalties,
                   const std::uint8_t* cost, PathWorkspace& w, RowWinner* winners) {
  const RowPaths row{y, padded, penalties, cost, w};
  if (y == 0) start(left.width, padded, row.guard(), w);
  if (y == 0 || !(search == w.search)) {
    w.search = search;
    w.stale_rows = 2;
  }
  // Disparities that are not searched stay guards, so that paths may come from any other search.
  if (w.stale_rows > 0) {
    --w.stale_rows;
    const std::int32_t stride = padded + path_guard;
    for (PathRow& paths : w.from_above[y & 1]) {
      std::fill_n(paths.costs.data() + stride, static_cast<std::ptrdiff_t>(left.width) * stride + path_guard,
                  row.guard());
    }
  }
  find_contrasts(left, y, w);
  PathEnd end{w.zero.data() + path_guard, U8{}};
  for (const SearchRun& run : w.search) {
    with_known_count(run.count, [&](auto count) { end = aggregate_forward(row, run, count, end); });
  }
  end = {w.zero.data() + path_guard, U8{}};
  for (std::int32_t i = w.search.size - 1; i >= 0; --i) {
    const SearchRun& run = w.search.runs[static_cast<std::size_t>(i)];
    const WinnerRule rule{std::min(run.count, disparities - run.first), lead};
    with_known_count(run.count, [&](auto count) { end = aggregate_backward(row, run, count, rule, end, winners); });
  }
}

}  // namespace ilp
