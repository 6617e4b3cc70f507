// Searches for one patch of the sheet in the window: normalised correlation at every shift, in integers except for the
// last division.
#pragma once

#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// The lags that are computed: [first_column, first_column + columns) and [first_row, first_row + rows). Lag (0, 0) is
/// the shift by (-search, -search) px.
struct LagRange {
  std::int32_t first_column = 0, first_row = 0;
  std::int32_t columns = 0, rows = 0;
};

struct PatchSearch {
  std::int32_t side = 0;  ///< side of the patch, px; even
  float value_share = 0;  ///< weight of the values; that of the directions is 1. 0: directions alone
};

/// The unit of scores. A score is the correlation of directions, or its sum with a share of the correlation of values.
inline constexpr std::int32_t map_score_one = 4096;
/// Score of a lag at which less than half of the patch's cells in the map are known.
inline constexpr std::int32_t unknown_score = -(1 << 30);

/// True if the patch has enough texture to be found.
[[nodiscard]] bool has_texture(const MapChannels<max_map_sheet_side>& sheet, const MapPatch& patch,
                               const PatchSearch& search);
/// Writes the score of each lag to workspace.surface (rows of map_lag_stride), and uses workspace.reach as scratch. The
/// patch must stay inside the window at all lags.
void search_patch(const MapPatch& patch, const PatchSearch& search, const LagRange& lags,
                  MapRegistrationWorkspace& workspace);

}  // namespace ilp
