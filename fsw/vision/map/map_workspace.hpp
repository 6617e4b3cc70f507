// Memory of a registration against a map. Its caller owns it from begin() to the last step().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "fsw/vision/map/map_window.hpp"

namespace ilp {

inline constexpr std::size_t max_map_patches = 96;
inline constexpr std::int32_t max_map_patch_side = 16;
inline constexpr std::int32_t max_map_lags = 2 * max_map_shift_px + 1;  ///< along each axis

/// Lags of a row are computed in groups of this size; the last group may go beyond the last lag.
inline constexpr std::int32_t map_lag_group = 32;
inline constexpr std::int32_t map_lag_stride = (max_map_lags + map_lag_group - 1) / map_lag_group * map_lag_group;
inline constexpr std::int32_t map_rows_at_once = 4;  ///< rows of lags; the last ones may lie beyond the last lag
inline constexpr std::int32_t map_reach_rows =
    (max_map_lags + map_rows_at_once - 1) / map_rows_at_once * map_rows_at_once + max_map_patch_side - 1;
inline constexpr std::int32_t map_reach_stride = map_lag_stride + max_map_patch_side;

/// Raw value of an unknown cell.
inline constexpr std::int16_t unknown_value = std::numeric_limits<std::int16_t>::min();

/// The channels by which a window and a sheet are compared, row by row. Raw values are grey in sixteenths, or heights
/// in sixty-fourths of a pixel. They are normalised to values with standard deviation 256, clamped at 8 of these. The
/// direction of a cell is the x and y of its gradient, with length 127 for a strong gradient and less for a weak one.
template <std::int32_t side>
struct MapChannels {
  static constexpr std::size_t cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);

  std::int32_t width = 0, height = 0;
  std::array<std::int16_t, cells> value;
  std::array<std::int8_t, 2 * cells> direction;

  [[nodiscard]] std::size_t at(std::int32_t column, std::int32_t row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
  }
};

/// A patch of the sheet, and the lag at which it was found.
struct MapPatch {
  std::int16_t column = 0, row = 0;            ///< position of its first cell in the sheet
  std::int16_t best_column = 0, best_row = 0;  ///< lag with its highest score
  std::int16_t quarter = 0;                    ///< 0 to 3: one of four interleaved subsets of the patches
  bool used = false;                           ///< it has texture, and enough of its search range is known
  bool placed = false;                         ///< near the verdict's place, to a part of a pixel:
  float placed_column = 0, placed_row = 0;     ///< shift, px
};

/// Capacity that the flight's memory has for the workspace.
inline constexpr std::size_t max_map_workspace_bytes = 650'000;

struct MapRegistrationWorkspace {
  MapChannels<max_map_window_side> window;
  MapChannels<max_map_sheet_side> sheet;
  std::array<std::uint8_t, static_cast<std::size_t>(max_map_sheet_side) * max_map_sheet_side> sheet_count;
  /// First the sums of the sheet's cells, then its integral image of known cells, then the summed surface of each
  /// quarter.
  std::array<std::int32_t, std::size_t{4} * max_map_lags * max_map_lags> sums;
  std::array<std::int32_t, static_cast<std::size_t>(map_reach_rows) * map_reach_stride> reach;
  std::array<std::int32_t, static_cast<std::size_t>(max_map_lags) * map_lag_stride> surface;
  std::array<MapPatch, max_map_patches> patches;
};
static_assert(sizeof(MapRegistrationWorkspace) <= max_map_workspace_bytes);
static_assert(std::size_t{4} * max_map_lags * max_map_lags >=
              static_cast<std::size_t>(max_map_sheet_side + 1) * (max_map_sheet_side + 1));

}  // namespace ilp
