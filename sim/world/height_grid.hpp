// True heights of the ground on a regular grid, with which merged elevation maps are compared.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>

#include "sim/host/image_io.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::world {

/// Column i, row j is at (x0 + i * cell, y0 - j * cell): y decreases from row to row.
struct HeightGrid {
  double x0 = 0, y0 = 0, cell = 0;  ///< m, world
  host::Raster<float> height_m;     ///< z in the world frame; not finite where no frame sees the ground
};

struct HeightGridParams {
  std::int32_t max_side = 3000;  ///< most cells per side; larger areas get larger cells
  std::int64_t max_cells = 6000000;
};

/// Writes the ground's z at (x0 + i * spacing, y) to height[i]. Called from several threads.
using HeightsAlongRow = std::function<void(double x0, double y, double spacing, std::span<double> height)>;

/// Builds a grid over all ground that the frames see. The cell size is the median size of a pixel on the ground, or
/// larger because of `params`. Empty if no frame has depth. `threads` is that of host::for_each_parallel.
[[nodiscard]] HeightGrid build_height_grid(std::span<const TrueFrame> frames, const HeightsAlongRow& heights,
                                           const HeightGridParams& params, std::size_t threads = 0);

/// Bilinear interpolation; NaN outside the grid and if one of the four samples around the point is not finite.
[[nodiscard]] double height_at(const HeightGrid& grid, double x, double y);

/// Writes height.pfm (+infinity for missing heights) with its ESRI world file height.pgw, which is the export format of
/// the ground programs, and the same heights as GeoTIFF height.tif. Throws std::runtime_error.
void write_height_grid(const HeightGrid& grid, const std::filesystem::path& folder);
/// Reads height.pfm and height.pgw. Throws std::runtime_error that names the file and what is wrong with it.
[[nodiscard]] HeightGrid read_height_grid(const std::filesystem::path& folder);

}  // namespace ilp::world
