// Where the pieces of a strip meet: one surface from the masked pieces of its keyframes.
#pragma once

#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// Closing and comparing seams in a part of a map depends on cells up to this far outside the part.
inline constexpr std::int32_t seam_reach_cells = 6;

/// Masks are disjoint, so that between two pieces a cell or two may stay empty. Such a cell, with covered cells of
/// different keyframes within two cells on opposite sides and no cliff between them, takes the height and brightness of
/// the line between these. Its count stays 0: nothing was measured there. Gaps inside a piece stay open: there the
/// ground was seen and not matched.
void close_seams(GroundGrid& grid);

}  // namespace ilp::map
