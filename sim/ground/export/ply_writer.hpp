// Surfaces as PLY files (binary, little-endian), which every viewer of point clouds and meshes opens.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/ground/map/merge.hpp"

namespace ilp::exports {

/// Vertices x y z (float) red green blue (uchar), faces as lists of three indices; `comment` is one line of the header.
[[nodiscard]] std::vector<std::uint8_t> ply_bytes(const map::SurfaceMesh& mesh, const std::string& comment);

}  // namespace ilp::exports
