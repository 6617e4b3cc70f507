// Closes the narrow gaps between the patches of a strip's keyframes, so that the map is one surface.
#pragma once

#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"

namespace ilp::map {

/// Closing and comparing seams in a part of a map depends on cells at most this far outside the part.
inline constexpr std::int32_t seam_reach_cells = 6;

/// Fills empty cells between two patches. Masks are disjoint, so that one or two cells may stay empty at a border. A
/// cell is filled if it has covered cells of different keyframes within two cells on opposite sides, without a cliff
/// between them. It gets height and brightness by linear interpolation; its count stays 0, because nothing was
/// measured. Gaps inside a patch, where the ground was seen but not matched, stay open.
void close_seams(GroundGrid& grid);

}  // namespace ilp::map
