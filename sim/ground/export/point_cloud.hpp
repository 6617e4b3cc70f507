// The points of a strip's structure as a PLY file (binary, little-endian), with what structure and motion says of each.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/ground/export/georeference.hpp"

namespace ilp::exports {

/// Grey value of a keyframe's image at a pixel, none where it has not come.
using GreyOf = std::function<std::optional<std::uint8_t>(std::int64_t keyframe_id, double x, double y)>;

/// Vertices x y z (double, map coordinates of `place`), red green blue (uchar; 128 where no image tells), error_px
/// (float, root mean square of its reprojection) and observations (uint). Points that are not finite are left out.
/// Empty when there is none.
[[nodiscard]] std::vector<std::uint8_t> point_cloud_ply(const intake::Flight& flight, const intake::Strip& strip,
                                                        const Georeference& place, const GreyOf& grey);

}  // namespace ilp::exports
