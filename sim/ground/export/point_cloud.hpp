// The points of a strip's structure as a PLY file (binary, little-endian), with what structure and motion says of each.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::exports {

/// Grey value of a keyframe's image at a pixel, none where it has not come.
using GreyOf = std::function<std::optional<std::uint8_t>(std::int64_t keyframe_id, double x, double y)>;

/// Vertices x y z (double, map coordinates of `place`), red green blue (uchar; 128 where no image tells), error_px
/// (float, root mean square of its reprojection) and observations (uint). Points that are not finite are left out.
/// Empty when there is none.
[[nodiscard]] std::vector<std::uint8_t> point_cloud_ply(const intake::Flight& flight, const intake::Strip& strip,
                                                        const Georeference& place, const GreyOf& grey);

// Surfaces as PLY files (binary, little-endian), which every viewer of point clouds and meshes opens.

/// Vertices x y z (float) red green blue (uchar), faces as lists of three indices; `comment` is one line of the header.
[[nodiscard]] std::vector<std::uint8_t> ply_bytes(const map::SurfaceMesh& mesh, const std::string& comment);

}  // namespace ilp::exports
