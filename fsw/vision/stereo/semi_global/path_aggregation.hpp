// Semi-global matching: dynamic programming along paths in five directions, row by row from the top, with two rows of
// memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/cost/row_winner.hpp"

namespace ilp {

/// Guard elements around the costs of every pixel. They are too expensive for any path, so that inner loops need no
/// bounds.
inline constexpr std::int32_t path_guard = 16;
inline constexpr std::size_t max_path_stride = static_cast<std::size_t>(max_padded_disparities) + path_guard;
/// Columns of a row of path costs. The paths from either side start at an additional column outside the image.
inline constexpr std::size_t max_path_columns = static_cast<std::size_t>(limits::max_rectified_width) + 2;
inline constexpr std::size_t max_path_row = max_path_columns * max_path_stride + path_guard;

inline constexpr int aggregated_paths = 5;
/// small_step_penalty: cost of a disparity change by one px, as on slanted ground. large_step_penalty: cost of any
/// larger change where the image is smooth. A path costs at most the matching cost plus a large step. Even with a small
/// step added the cost fits in a byte, and the sum of all paths in ten bits.
inline constexpr int small_step_penalty = 10, large_step_penalty = 140;
inline constexpr int max_path_sum = aggregated_paths * (max_matching_cost + large_step_penalty);
static_assert(max_matching_cost + large_step_penalty + small_step_penalty <= 255);
static_assert(max_path_sum < 1023);
/// Sum of an excluded disparity, higher than any other sum.
inline constexpr std::int16_t excluded_sum = max_path_sum + 1;

struct PathRow {
  alignas(64) std::array<std::uint8_t, max_path_row> costs;
};

struct PathWorkspace {
  PathRow from_above[2][3];  ///< [row parity][from above left, above, above right]
  /// [row parity]. Per column 16 bytes: four unused ones, then the lowest cost of each of the three paths from above,
  /// each repeated four times.
  alignas(64) std::array<std::uint8_t, max_path_columns * 16> lowest[2];
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> along[2];
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> zero;
  alignas(64) std::array<std::int16_t, max_cost_entries> sum;  ///< sum of the path costs, by column and disparity
  /// Per path: grey difference between a pixel and the previous pixel of the path.
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)> contrast[aggregated_paths];
  SearchRow search;             ///< disparities that the latest row searched
  std::int32_t stale_rows = 0;  ///< rows of `from_above` that another search wrote
};

inline constexpr std::size_t large_step_copies = 4;
struct PathPenalties {
  /// Penalty of a large step, by the grey difference of the two pixels; each value is repeated large_step_copies times.
  alignas(64) std::array<std::uint8_t, std::size_t{256} * large_step_copies> large_step{};
};
[[nodiscard]] PathPenalties make_path_penalties(const StereoParams& params);

/// Aggregates the costs of row `y` and chooses the winners. For each path direction r it computes (H. Hirschmueller,
/// PAMI 30(2), 2008, eq. 13)
///   L(p, d) = C(p, d) + min(L(p-r, d), L(p-r, d +- 1) + P1, min_i L(p-r, i) + P2) - min_i L(p-r, i)
/// which stays in 0..255, so that a path costs one byte per disparity. The five paths come from the left, the right,
/// above, above left and above right. `winners[x]` is the disparity with the lowest sum of the five. Disparities that
/// `search` leaves out, and indices from `disparities` on, cannot win, and no path uses them. A winner is unique if its
/// sum is lower than that of any other by at least `lead`. Rows must come in order; `y` = 0 starts again.
void aggregate_row(GrayView left, std::int32_t y, const SearchRow& search, std::int32_t padded,
                   std::int32_t disparities, std::int32_t lead, const PathPenalties& penalties,
                   const std::uint8_t* cost, PathWorkspace& workspace, RowWinner* winners);

}  // namespace ilp
