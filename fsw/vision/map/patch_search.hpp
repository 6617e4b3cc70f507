// Looks for one patch of the sheet in the window: normalised correlation at every shift, in whole numbers but for the
// last division.
#pragma once

#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Lags [first, first + count) along each axis. Lag (0, 0) is the shift by (-search, -search) px.
struct LagRange {
  std::int32_t first_column = 0, first_row = 0;
  std::int32_t columns = 0, rows = 0;
};

struct PatchSearch {
  std::int32_t side = 0;  ///< of the patch, px; even
  float value_share = 0;  ///< of values beside directions, which have 1; 0: directions alone
};

/// In units of `map_score_one`: the correlation of directions, or its sum with a share of that of values.
inline constexpr std::int32_t map_score_one = 4096;
/// Of a lag at which the map knows less than half of the patch.
inline constexpr std::int32_t unknown_score = -(1 << 30);

/// Whether the patch has anything to be known by.
[[nodiscard]] bool has_texture(const MapChannels<max_map_sheet_side>& sheet, const MapPatch& patch,
                               const PatchSearch& search);
/// Writes workspace.surface (rows of map_lag_stride) and uses workspace.reach. The lags lie inside the window.
void search_patch(const MapPatch& patch, const PatchSearch& search, const LagRange& lags,
                  MapRegistrationWorkspace& workspace);

}  // namespace ilp
