// Makes pictures of a strip seen from above, rotated so that the flight goes from left to right.
#pragma once

#include <array>
#include <vector>

#include "sim/ground/map/ground_grid.hpp"
#include "sim/host/picture.hpp"

namespace ilp::report {

/// Transforms between the world's x, y and pixels of a picture. `along`: coordinate in the flight direction; `across`:
/// coordinate to its left; both in strip units.
struct PlanView {
  double cosine = 1, sine = 0;            ///< of the flight direction's angle in the world
  double along_low = 0, across_high = 0;  ///< coordinates of the picture's pixel (0, 0)
  double unit_per_px = 1;
  std::int32_t width = 0, height = 0;

  [[nodiscard]] double along(double x, double y) const { return cosine * x + sine * y; }
  [[nodiscard]] double across(double x, double y) const { return -sine * x + cosine * y; }
  [[nodiscard]] double px(double x, double y) const { return (along(x, y) - along_low) / unit_per_px; }
  [[nodiscard]] double py(double x, double y) const { return (across_high - across(x, y)) / unit_per_px; }
  /// The world's x and y of a pixel.
  [[nodiscard]] std::array<double, 2> world(std::int32_t column, std::int32_t row) const {
    const double u = along_low + column * unit_per_px, v = across_high - row * unit_per_px;
    return {cosine * u - sine * v, sine * u + cosine * v};
  }
};

/// A view that contains the grid (may be null) and the track, at most max_width by max_height pixels.
[[nodiscard]] PlanView make_plan_view(const map::GroundGrid* grid, const std::vector<Vec3>& track,
                                      std::int32_t max_width, std::int32_t max_height);

/// The grid resampled to the view's pixels, with small holes closed and contrast stretched: for pictures only.
struct ViewSurface {
  host::Raster<float> relief;  ///< height above the mean plane, strip units; NaN: not measured
  host::Raster<float> laid;    ///< the same for ground on interpolated heights (LaidGround); NaN elsewhere
  host::Raster<std::uint8_t> ortho;
  host::Raster<float> shade;  ///< shading, 0 dark to 1 bright, lit from the upper left
  double exaggeration = 1;    ///< factor of heights in the shading
};
[[nodiscard]] ViewSurface resample(const map::GroundGrid& grid, const map::Plane& plane, const PlanView& view);

/// The orthoimage. Ground on interpolated heights is hatched in the colour laid_hatch; other pixels without a height
/// are transparent.
inline constexpr host::Rgba laid_hatch{214, 130, 70, 255};
[[nodiscard]] host::Raster<host::Rgba> ortho_picture(const ViewSurface& surface);
/// Heights above the mean plane, colour-coded and shaded.
[[nodiscard]] host::Raster<host::Rgba> relief_picture(const ViewSurface& surface, const host::ValueRange& range,
                                                      host::ColourMap colours = host::viridis);

}  // namespace ilp::report
