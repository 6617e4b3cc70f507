// The terrain with the flight above it, seen at a slant from the right of the track.
#pragma once

#include <array>
#include <vector>

#include "sim/ground/report/plan_view.hpp"

namespace ilp::report {

struct ObliqueView {
  host::Raster<host::Rgba> picture;
  std::vector<std::array<double, 2>> track;  ///< picture px of the camera centres
  std::vector<std::array<double, 2>> below;  ///< picture px of the mean plane below them
  double exaggeration = 1;                   ///< of heights above the mean plane
};

/// A painter with depth buffer: perspective, the orthoimage as texture, shaded.
[[nodiscard]] ObliqueView draw_oblique(const ViewSurface& surface, const PlanView& view, const map::Plane& plane,
                                       const std::vector<Vec3>& track, std::int32_t width);

}  // namespace ilp::report
