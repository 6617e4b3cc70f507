// The closed grid of a strip as one triangulated surface.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::map {

/// One vertex for every n-th cell of every n-th row that has a height, coloured by the orthoimage; triangles between
/// neighbours whose heights differ by no more than max_depth_jump times their distance: what is steeper is a wall that
/// nobody measured. Neighbouring pieces share vertices, so that the surface has no seams but where the map has gaps.
[[nodiscard]] SurfaceMesh grid_surface(const GroundGrid& grid, std::int32_t stride, const MergeParams& params);

/// The smallest stride with at most `max_vertices` vertices.
[[nodiscard]] std::int32_t stride_for(const GroundGrid& grid, std::size_t max_vertices);

}  // namespace ilp::map
