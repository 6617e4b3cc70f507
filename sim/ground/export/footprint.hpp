// Computes the outline of the ground that an image shows.
#pragma once

#include <functional>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/map/ground_grid.hpp"

namespace ilp::exports {

/// Intersections of the image border's lines of sight with the surface, in the strip's world, clockwise in the image
/// from its top left corner. Empty if a line of sight does not meet the surface within twenty flying heights. `plane`:
/// mean plane of the surface. `relief`: height of the surface above the plane at x, y; 0 where it is unknown.
[[nodiscard]] std::vector<Vec3> footprint(const CameraModel& camera, const Pose& pose, const map::Plane& plane,
                                          const std::function<double(double x, double y)>& relief);

}  // namespace ilp::exports
