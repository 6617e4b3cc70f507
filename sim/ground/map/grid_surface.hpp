// Triangulates the map of a strip, whose seams are closed, as one surface.
#pragma once

#include <cstddef>
#include <cstdint>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::map {

/// Makes one vertex of every `stride`-th cell of every `stride`-th row that has a height, with the grey value of the
/// orthoimage. Neighbours make a triangle if their heights differ by at most max_depth_jump * stride * cell: steeper
/// walls were not measured. Patches of neighbouring keyframes share vertices, so that only gaps of the map interrupt
/// the surface.
[[nodiscard]] SurfaceMesh grid_surface(const GroundGrid& grid, std::int32_t stride, const MergeParams& params);

/// The smallest stride with at most `max_vertices` vertices.
[[nodiscard]] std::int32_t stride_for(const GroundGrid& grid, std::size_t max_vertices);

}  // namespace ilp::map
