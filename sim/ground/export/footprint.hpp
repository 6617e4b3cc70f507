// The ground that an image shows.
#pragma once

#include <functional>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// Where the border of the image meets the surface, clockwise from the top left corner; empty when a part of it does
/// not, or only farther off than twenty flying heights. `relief` is the surface's height above its mean plane at x, y
/// of the strip's world, 0 where it is not known.
[[nodiscard]] std::vector<Vec3> footprint(const CameraModel& camera, const Pose& pose, const map::Plane& plane,
                                          const std::function<double(double x, double y)>& relief);

}  // namespace ilp::exports
