#include "sim/world/height_grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/host/geo_raster.hpp"
#include "sim/host/parallel.hpp"

namespace ilp::world {
namespace {

constexpr float nothing = std::numeric_limits<float>::infinity();

double median_ground_pixel(std::span<const TrueFrame> frames) {
  std::vector<double> sizes;
  for (const TrueFrame& frame : frames) {
    std::vector<double> own;
    for (const float z : frame.depth) {
      if (z > 0 && std::isfinite(z)) own.push_back(z / frame.camera.fx);
    }
    if (own.empty()) continue;
    const auto middle = own.begin() + static_cast<std::ptrdiff_t>(own.size() / 2);
    std::nth_element(own.begin(), middle, own.end());
    sizes.push_back(*middle);
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return *middle;
}

struct Area {
  double x_low = std::numeric_limits<double>::infinity(), x_high = -x_low;
  double y_low = x_low, y_high = -x_low;
};

Area common_area(std::span<const TrueFrame> frames) {
  Area area;
  for (const TrueFrame& frame : frames) {
    if (!frame.low.allFinite() || !frame.high.allFinite()) continue;
    area.x_low = std::min(area.x_low, frame.low.x());
    area.x_high = std::max(area.x_high, frame.high.x());
    area.y_low = std::min(area.y_low, frame.low.y());
    area.y_high = std::max(area.y_high, frame.high.y());
  }
  return area;
}

void fill_row(std::span<const TrueFrame> frames, const HeightsAlongRow& heights, int row, HeightGrid& grid) {
  std::vector<double> height(static_cast<std::size_t>(grid.height_m.width));
  const double y = grid.y0 - row * grid.cell;
  heights(grid.x0, y, grid.cell, height);
  const TrueFrame* last = &frames.front();
  for (int column = 0; column < grid.height_m.width; ++column) {
    const Vec3 point(grid.x0 + column * grid.cell, y, height[static_cast<std::size_t>(column)]);
    bool seen = sees(*last, point);
    for (std::size_t k = 0; k < frames.size() && !seen; ++k) {
      seen = sees(frames[k], point);
      if (seen) last = &frames[k];
    }
    if (seen) grid.height_m.at(column, row) = static_cast<float>(point.z());
  }
}

std::runtime_error bad(const std::filesystem::path& path, const std::string& what) {
  return std::runtime_error(path.string() + ": " + what);
}

}  // namespace

HeightGrid build_height_grid(std::span<const TrueFrame> frames, const HeightsAlongRow& heights,
                             const HeightGridParams& params, std::size_t threads) {
  HeightGrid grid;
  const double pixel = median_ground_pixel(frames);
  if (!(pixel > 0)) return grid;
  const Area area = common_area(frames);
  const double width = area.x_high - area.x_low, depth = area.y_high - area.y_low;
  grid.cell = std::max({pixel, std::max(width, depth) / (params.max_side - 1),
                        std::sqrt(width * depth / static_cast<double>(params.max_cells))});
  grid.x0 = area.x_low;
  grid.y0 = area.y_high;
  grid.height_m =
      host::Raster<float>(static_cast<int>(width / grid.cell) + 1, static_cast<int>(depth / grid.cell) + 1, nothing);
  host::for_each_parallel(
      static_cast<std::size_t>(grid.height_m.height),
      [&](std::size_t row) { fill_row(frames, heights, static_cast<int>(row), grid); }, threads);
  return grid;
}

double height_at(const HeightGrid& grid, double x, double y) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double column = (x - grid.x0) / grid.cell, row = (grid.y0 - y) / grid.cell;
  const int width = grid.height_m.width, height = grid.height_m.height;
  if (width < 2 || height < 2 || !(column >= 0) || !(row >= 0) || column > width - 1 || row > height - 1) return none;
  const int i = std::min(static_cast<int>(column), width - 2), j = std::min(static_cast<int>(row), height - 2);
  const double u = column - i, v = row - j;
  const double z = (1 - v) * ((1 - u) * grid.height_m.at(i, j) + u * grid.height_m.at(i + 1, j)) +
                   v * ((1 - u) * grid.height_m.at(i, j + 1) + u * grid.height_m.at(i + 1, j + 1));
  return std::isfinite(z) ? z : none;
}

void write_height_grid(const HeightGrid& grid, const std::filesystem::path& folder) {
  host::write_pfm(folder / "height.pfm", grid.height_m.view());
  const std::filesystem::path path = folder / "height.pgw";
  std::ofstream out(path, std::ios::binary);
  out.imbue(std::locale::classic());
  out.precision(17);
  out << grid.cell << "\n0\n0\n" << -grid.cell << "\n" << grid.x0 << "\n" << grid.y0 << "\n";
  if (!out.flush()) throw bad(path, "cannot be written");
  host::Raster<float> heights = grid.height_m;
  for (float& z : heights.samples) {
    if (!std::isfinite(z)) z = std::numeric_limits<float>::quiet_NaN();
  }
  host::write_geotiff(folder / "height.tif", heights.view(), {grid.x0, grid.y0, grid.cell, grid.cell});
}

HeightGrid read_height_grid(const std::filesystem::path& folder) {
  HeightGrid grid;
  const std::filesystem::path path = folder / "height.pgw";
  std::ifstream in(path);
  if (!in) throw bad(path, "cannot be read; expected the world file of height.pfm");
  in.imbue(std::locale::classic());
  std::array<double, 6> world{};
  for (double& number : world) in >> number;
  if (!in || !(world[0] > 0) || world[1] != 0 || world[2] != 0 || world[3] != -world[0] ||
      !std::isfinite(world[0] + world[4] + world[5])) {
    throw bad(path, "expected six numbers: cell, 0, 0, -cell, x and y of the top-left sample");
  }
  grid.cell = world[0];
  grid.x0 = world[4];
  grid.y0 = world[5];
  grid.height_m = host::read_pfm(folder / "height.pfm");
  return grid;
}

}  // namespace ilp::world
