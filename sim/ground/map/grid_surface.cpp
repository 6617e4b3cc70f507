#include "sim/ground/map/grid_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ilp::map {
namespace {

host::Raster<std::uint32_t> add_vertices(const GroundGrid& grid, std::int32_t stride, SurfaceMesh& mesh) {
  const host::Raster<float>& stated = grid.estimated_sigma();
  host::Raster<std::uint32_t> index((grid.height.width + stride - 1) / stride,
                                    (grid.height.height + stride - 1) / stride, no_vertex);
  for (std::int32_t y = 0; y < index.height; ++y) {
    for (std::int32_t x = 0; x < index.width; ++x) {
      const std::int32_t u = x * stride, v = y * stride;
      const float z = grid.height.at(u, v);
      if (!std::isfinite(z)) continue;
      index.at(x, y) = static_cast<std::uint32_t>(mesh.vertices.size());
      const float sigma = stated.empty() || !std::isfinite(stated.at(u, v)) ? 0.0F : stated.at(u, v);
      mesh.vertices.push_back({static_cast<float>(grid.x0 + u * grid.cell), static_cast<float>(grid.y0 - v * grid.cell),
                               z, grid.ortho.at(u, v), sigma});
    }
  }
  return index;
}

}  // namespace

SurfaceMesh grid_surface(const GroundGrid& grid, std::int32_t stride, const MergeParams& params) {
  SurfaceMesh mesh;
  const host::Raster<std::uint32_t> index = add_vertices(grid, stride, mesh);
  const double steepest = params.max_depth_jump * stride * grid.cell;
  const auto add_triangle = [&](const std::array<std::uint32_t, 3>& face) {
    if (std::find(face.begin(), face.end(), no_vertex) != face.end()) return;
    const float a = mesh.vertices[face[0]].z, b = mesh.vertices[face[1]].z, c = mesh.vertices[face[2]].z;
    if (std::max({a, b, c}) - std::min({a, b, c}) <= steepest) mesh.faces.push_back(face);
  };
  for (std::int32_t y = 0; y + 1 < index.height; ++y) {
    for (std::int32_t x = 0; x + 1 < index.width; ++x) {
      add_triangle({index.at(x, y), index.at(x, y + 1), index.at(x + 1, y)});
      add_triangle({index.at(x + 1, y), index.at(x, y + 1), index.at(x + 1, y + 1)});
    }
  }
  return mesh;
}

std::int32_t stride_for(const GroundGrid& grid, std::size_t max_vertices) {
  const auto vertices = [&](std::int32_t stride) {
    std::size_t count = 0;
    for (std::int32_t y = 0; y < grid.height.height; y += stride) {
      for (std::int32_t x = 0; x < grid.height.width; x += stride) count += std::isfinite(grid.height.at(x, y)) ? 1 : 0;
    }
    return count;
  };
  std::int32_t stride = 1;
  while (vertices(stride) > std::max<std::size_t>(max_vertices, 1)) ++stride;
  return stride;
}

}  // namespace ilp::map
