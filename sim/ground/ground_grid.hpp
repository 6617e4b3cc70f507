// The elevation map of a strip: a regular grid in the strip's world with heights and an orthoimage (decisions.md, 8).
#pragma once

#include <optional>

#include "sim/ground/merge.hpp"

namespace ilp::ground {

/// Column i, row j stands at world (x0 + i * cell, y0 - j * cell): north (+y) is up, cell (0,0) is the top-left centre.
struct GroundGrid {
  double x0 = 0, y0 = 0, cell = 0;  ///< strip units
  Raster<float> height;             ///< world z; NaN where nothing was seen
  Raster<float> sigma;              ///< one sigma of the height, from matching; NaN where it is not told
  Raster<std::uint8_t> ortho;       ///< grey value seen from above
  Raster<std::uint16_t> count;      ///< keyframes whose surface covers the cell
  Raster<std::uint16_t> source;     ///< 1 + place in the strip's keyframes of the one that is shown; 0: none
  /// Where two keyframes cover a cell: how much their heights differ, strip units; 0 where none do.
  std::size_t seam_cells = 0;
  double seam_step_median = 0, seam_step_p95 = 0;

  [[nodiscard]] double column_of(double x) const { return (x - x0) / cell; }
  [[nodiscard]] double row_of(double y) const { return (y0 - y) / cell; }
  [[nodiscard]] double covered_area() const;  ///< square strip units
};

struct GridParams {
  std::int32_t max_side = 3000;  ///< cells
  std::int64_t max_cells = 6000000;
};

/// Seams are closed and exposures balanced (seams.hpp). The cell is the median distance of neighbouring pixels on the
/// ground, or more where the grid would get too large. None when no keyframe of the strip has a surface.
[[nodiscard]] std::optional<GroundGrid> build_grid(const Flight& flight, const Strip& strip, const GridParams& params,
                                                   PixelRays& rays);

/// z = a x + b y + c.
struct Plane {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double at(double x, double y) const { return a * x + b * y + c; }
};
/// Least squares over all heights. The mean slope of a strip whose world has no gravity is a matter of its first
/// camera; pictures show relief above it.
[[nodiscard]] Plane mean_plane(const GroundGrid& grid);

}  // namespace ilp::ground
