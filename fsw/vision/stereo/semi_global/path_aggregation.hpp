// Dynamic programming along scanlines in five directions, streaming downwards with two rows of memory.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "fsw/vision/stereo/cost/ncc_cost.hpp"
#include "fsw/vision/stereo/cost/row_winner.hpp"

namespace ilp {

/// Guards around every pixel's costs are too expensive for any path, so that inner loops need no bounds.
inline constexpr std::int32_t path_guard = 16;
inline constexpr std::size_t max_path_stride = static_cast<std::size_t>(max_padded_disparities) + path_guard;
/// The paths from either side start at an extra column there.
inline constexpr std::size_t max_path_columns = static_cast<std::size_t>(limits::max_rectified_width) + 2;
inline constexpr std::size_t max_path_row = max_path_columns * max_path_stride + path_guard;

inline constexpr int aggregated_paths = 5;
/// Cost of a change by one px, as on slanted ground, and of any larger change where the image is smooth. A path costs
/// at most the matching cost and a large step: with a small one on top it stays in a byte, and the sum of all paths in
/// ten bits.
inline constexpr int small_step_penalty = 10, large_step_penalty = 140;
inline constexpr int max_path_sum = aggregated_paths * (max_matching_cost + large_step_penalty);
static_assert(max_matching_cost + large_step_penalty + small_step_penalty <= 255);
static_assert(max_path_sum < 1023);
/// Higher than any sum.
inline constexpr std::int16_t excluded_sum = max_path_sum + 1;

struct PathRow {
  alignas(64) std::array<std::uint8_t, max_path_row> costs;
};

struct PathWorkspace {
  PathRow from_above[2][3];  ///< [row parity][from above left, above, above right]
  /// [row parity], per column 16 bytes: four that are not used, and the lowest cost of each of the three paths from
  /// above, four times.
  alignas(64) std::array<std::uint8_t, max_path_columns * 16> lowest[2];
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> along[2];
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> zero;
  alignas(64) std::array<std::int16_t, max_cost_entries> sum;  ///< of the paths, by column
  /// Per path the grey difference between a pixel and the path's previous pixel.
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)> contrast[aggregated_paths];
  SearchRow search;             ///< of the latest row
  std::int32_t stale_rows = 0;  ///< rows of `from_above` that another search wrote
};

inline constexpr std::size_t large_step_copies = 4;
struct PathPenalties {
  /// By grey difference of the two pixels, large_step_copies times each.
  alignas(64) std::array<std::uint8_t, std::size_t{256} * large_step_copies> large_step{};
};
[[nodiscard]] PathPenalties make_path_penalties(const StereoParams& params);

/// Computes per path r (H. Hirschmueller, PAMI 30(2), 2008, eq. 13):
///   L(p, d) = C(p, d) + min(L(p-r, d), L(p-r, d +- 1) + P1, min_i L(p-r, i) + P2) - min_i L(p-r, i)
/// which stays in 0..255, so that a path costs one byte per disparity. The five paths come from the left, the right,
/// above, above left and above right; `winners[x]` has the lowest sum of them. Disparities that `search` leaves out and
/// those beyond `disparities` cannot win, and no path uses them. A unique winner must be lower than any other by
/// `lead`. Rows are taken in order; `y` = 0 starts over.
void aggregate_row(GrayView left, std::int32_t y, const SearchRow& search, std::int32_t padded,
                   std::int32_t disparities, std::int32_t lead, const PathPenalties& penalties,
                   const std::uint8_t* cost, PathWorkspace& workspace, RowWinner* winners);

}  // namespace ilp
