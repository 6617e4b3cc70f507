// Dynamic programming along scanlines in five directions, streaming downwards with two rows of memory.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/vision/stereo/ncc_cost.hpp"

namespace ilp {

/// Every pixel's costs stand between guards that no path can prefer, so that inner loops need no bounds.
inline constexpr std::int32_t path_guard = 16;
inline constexpr std::size_t max_path_stride = static_cast<std::size_t>(max_padded_disparities) + path_guard;
inline constexpr std::size_t max_path_row =
    static_cast<std::size_t>(limits::max_rectified_width) * max_path_stride + path_guard;

inline constexpr int aggregated_paths = 5;
inline constexpr int max_small_step = 31;
/// A path costs at most the matching cost and a large step: with max_small_step on top it stays in a byte, and the sum
/// of all paths in ten bits.
inline constexpr int max_large_step = 140;
inline constexpr int max_path_sum = aggregated_paths * (max_matching_cost + max_large_step);
static_assert(max_matching_cost + max_large_step + max_small_step <= 255);
static_assert(max_path_sum < 1023);

struct PathRow {
  alignas(64) std::array<std::uint8_t, max_path_row> costs;
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)> lowest;  ///< per pixel
};

struct PathWorkspace {
  PathRow from_above[2][3];  ///< [row parity][from above left, above, above right]
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> along[2];
  alignas(64) std::array<std::uint8_t, max_path_stride + path_guard> zero;
  SearchRow search;             ///< of the latest row
  std::int32_t stale_rows = 0;  ///< rows of `from_above` that another search wrote
};

struct PathPenalties {
  std::int32_t small_step = 0;
  std::array<std::uint8_t, 256> large_step{};  ///< by grey difference of the two pixels
};
[[nodiscard]] PathPenalties make_path_penalties(const StereoParams& params);

/// Per path r (H. Hirschmueller, PAMI 30(2), 2008, eq. 13):
///   L(p, d) = C(p, d) + min(L(p-r, d), L(p-r, d +- 1) + P1, min_i L(p-r, i) + P2) - min_i L(p-r, i)
/// which stays in 0..255, so that a path costs one byte per disparity. `sum[x * padded + i]` = L of all five paths:
/// from the left, the right, above, above left and above right. Disparities that `search` leaves out are neither
/// written nor taken by any path. Rows come in order; `y` = 0 starts anew.
void aggregate_row(GrayView left, std::int32_t y, const SearchRow& search, std::int32_t padded,
                   const PathPenalties& penalties, const std::uint8_t* cost, PathWorkspace& workspace,
                   std::int16_t* sum);

}  // namespace ilp
