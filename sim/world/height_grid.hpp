// True heights of the ground on a regular grid: what a merged elevation map is compared with.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>

#include "sim/host/image_io.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::world {

/// Column i, row j stands at (x0 + i * cell, y0 - j * cell): north (+y) is up, sample (0,0) is the top-left one.
struct HeightGrid {
  double x0 = 0, y0 = 0, cell = 0;  ///< m, world
  host::Raster<float> height_m;     ///< world z; not finite where no frame sees the ground
};

struct HeightGridParams {
  std::int32_t max_side = 3000;  ///< cells; a larger area gets larger cells
  std::int64_t max_cells = 6000000;
};

/// The ground's z at (x0 + i * spacing, y) into height[i]. Called from several threads.
using HeightsAlongRow = std::function<void(double x0, double y, double spacing, std::span<double> height)>;

/// A grid over all ground that the frames see, spaced by the median size of a pixel on the ground. Empty when no frame
/// has depth. `threads` as for_each_parallel takes it.
[[nodiscard]] HeightGrid build_height_grid(std::span<const TrueFrame> frames, const HeightsAlongRow& heights,
                                           const HeightGridParams& params, std::size_t threads = 0);

/// Bilinear; NaN outside and where one of the four samples around is not finite.
[[nodiscard]] double height_at(const HeightGrid& grid, double x, double y);

/// height.pfm (+infinity where there is none) with its ESRI world file height.pgw, the ground programs' export format,
/// and the same as GeoTIFF, height.tif. Throws std::runtime_error.
void write_height_grid(const HeightGrid& grid, const std::filesystem::path& folder);
/// Reads height.pfm and height.pgw. std::runtime_error names the file and what is wrong with it.
[[nodiscard]] HeightGrid read_height_grid(const std::filesystem::path& folder);

}  // namespace ilp::world
