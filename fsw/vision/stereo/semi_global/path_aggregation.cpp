#include "fsw/vision/stereo/semi_global/path_aggregation.hpp"

#include <algorithm>
#include <type_traits>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/cost/lanes.hpp"

namespace ilp {
namespace {

using lanes::I16;
using lanes::U8;
static_assert(disparity_block == lanes::bytes && path_guard >= 1);

enum Path : int { from_left, from_above_left, from_above, from_above_right, from_right };

// The lowest previous cost may be of a disparity that is not searched here. Then all costs are higher than this, and
// this value can be subtracted instead.
constexpr std::uint8_t max_lowest = 255 - large_step_penalty;
static_assert(max_lowest >= max_matching_cost);

U8 every(int value) {
  return U8{} + static_cast<std::uint8_t>(value);
}

// A key holds a sum and its disparity in a group, so that the lowest key gives both.
constexpr std::int32_t key_group = 64;
constexpr int key_bits = 6;
static_assert(excluded_sum < 1 << (16 - key_bits));

/// The state before the first row: zero costs between guards.
void clear(std::uint8_t* costs, std::int32_t columns, std::int32_t padded, std::uint8_t guard) {
  const std::int32_t stride = padded + path_guard;
  std::fill_n(costs, static_cast<std::ptrdiff_t>(columns) * stride + path_guard, guard);
  for (std::int32_t x = 0; x < columns; ++x)
    std::fill_n(costs + path_guard + static_cast<std::ptrdiff_t>(x) * stride, padded, std::uint8_t{0});
}

void find_contrast(const std::uint8_t* grey, const std::uint8_t* other, std::int32_t count, std::uint8_t* contrast) {
  std::int32_t x = 0;
  for (; x + lanes::bytes <= count; x += lanes::bytes) {
    const U8 a = lanes::load<U8>(grey + x);
    const U8 b = lanes::load<U8>(other + x);
    lanes::store(contrast + x, (a > b ? a : b) - lanes::lower(a, b));
  }
  for (; x < count; ++x) {
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

  [[nodiscard]] std::uint8_t guard() const { return static_cast<std::uint8_t>(255 - small_step_penalty); }
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

struct WinnerRule {
  std::int32_t searched;  ///< disparities of the run; those beyond are padding
  std::int32_t lead;
};

namespace with_16_bytes {
#define ILP_PATH_BYTES 16
#include "fsw/vision/stereo/semi_global/path_steps.inc"
#undef ILP_PATH_BYTES
}  // namespace with_16_bytes

#if defined(__x86_64__) && !defined(__clang__) && !defined(__AVX2__)
#define ILP_PATHS_WITH_32_BYTES
#pragma GCC push_options
#pragma GCC target("avx2")
#define ILP_PATH_AVX2
namespace with_32_bytes {
#define ILP_PATH_BYTES 32
#include "fsw/vision/stereo/semi_global/path_steps.inc"
#undef ILP_PATH_BYTES
}  // namespace with_32_bytes
/// For runs that vectors of 32 bytes do not fill: the same instructions with fewer bytes.
namespace with_half_of_32_bytes {
#define ILP_PATH_BYTES 16
#include "fsw/vision/stereo/semi_global/path_steps.inc"
#undef ILP_PATH_BYTES
}  // namespace with_half_of_32_bytes
#undef ILP_PATH_AVX2
#pragma GCC pop_options
#endif

PathEnd pass_forward(const RowPaths& row, const SearchRun& run, const PathEnd& behind) {
#ifdef ILP_PATHS_WITH_32_BYTES
  if (vectors_in_use() == VectorWidth::bytes32) {
    return run.count % 32 == 0 ? with_32_bytes::pass_forward(row, run, behind)
                               : with_half_of_32_bytes::pass_forward(row, run, behind);
  }
#endif
  return with_16_bytes::pass_forward(row, run, behind);
}

PathEnd pass_backward(const RowPaths& row, const SearchRun& run, const WinnerRule& rule, const PathEnd& behind,
                      RowWinner* winners) {
#ifdef ILP_PATHS_WITH_32_BYTES
  if (vectors_in_use() == VectorWidth::bytes32) {
    return run.count % 32 == 0 ? with_32_bytes::pass_backward(row, run, rule, behind, winners)
                               : with_half_of_32_bytes::pass_backward(row, run, rule, behind, winners);
  }
#endif
  return with_16_bytes::pass_backward(row, run, rule, behind, winners);
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
  constexpr int edge_grey = 4;  // difference from which a large step becomes cheaper
  const int least = std::clamp(params.min_large_step_penalty, small_step_penalty, large_step_penalty);
  for (int grey = 0; grey < 256; ++grey) {
    // Inverse to the gradient beyond edge_grey, as a depth edge is usually an image edge.
    const int penalty = grey <= edge_grey ? large_step_penalty : large_step_penalty * edge_grey / grey;
    std::fill_n(penalties.large_step.begin() + std::ptrdiff_t{grey} * large_step_copies, large_step_copies,
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
  for (const SearchRun& run : w.search) end = pass_forward(row, run, end);
  end = {w.zero.data() + path_guard, U8{}};
  for (std::int32_t i = w.search.size - 1; i >= 0; --i) {
    const SearchRun& run = w.search.runs[static_cast<std::size_t>(i)];
    const WinnerRule rule{std::min(run.count, disparities - run.first), lead};
    end = pass_backward(row, run, rule, end, winners);
  }
}

}  // namespace ilp
