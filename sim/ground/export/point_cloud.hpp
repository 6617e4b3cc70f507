// Writes PLY files (binary, little-endian): the points of a strip's structure with their quality, and surfaces.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/export/georeference.hpp"
#include "sim/ground/map/merge.hpp"

namespace ilp::exports {

/// Grey value of a keyframe's image at a pixel; none if the image has not come.
using GreyOf = std::function<std::optional<std::uint8_t>(std::int64_t keyframe_id, double x, double y)>;

/// The structure of a strip. Vertex properties: x y z (double, map coordinates of `place`), red green blue (uchar; 128
/// if no image has the point), error_px (float, RMS reprojection error) and observations (uint). Points that are not
/// finite are left out. Empty if there are no points.
[[nodiscard]] std::vector<std::uint8_t> point_cloud_ply(const intake::Flight& flight, const intake::Strip& strip,
                                                        const Georeference& place, const GreyOf& grey);

/// A surface. Vertex properties: x y z (float), red green blue (uchar). Faces are lists of three indices. `comment`:
/// one line for the header.
[[nodiscard]] std::vector<std::uint8_t> ply_bytes(const map::SurfaceMesh& mesh, const std::string& comment);

}  // namespace ilp::exports
