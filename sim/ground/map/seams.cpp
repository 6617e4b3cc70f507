#include "sim/ground/map/seams.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace ilp::map {
namespace {

constexpr std::int32_t max_gap_cells = 2;
// Heights on both sides of a seam differ by no more than a wall of 76 degrees would (MergeParams::max_depth_jump).
constexpr double max_slope = 4;
constexpr std::array<std::array<std::int32_t, 2>, 4> directions = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

struct Side {
  std::int32_t x = 0, y = 0, cells = 0;  ///< distance
};

/// The nearest covered cell that way, at most max_gap_cells off; cells 0: none.
Side covered_towards(const host::Raster<std::uint16_t>& source, std::int32_t x, std::int32_t y, std::int32_t dx,
                     std::int32_t dy) {
  for (std::int32_t k = 1; k <= max_gap_cells; ++k) {
    const std::int32_t u = x + k * dx, v = y + k * dy;
    if (u < 0 || v < 0 || u >= source.width || v >= source.height) return {};
    if (source.at(u, v) != 0) return {u, v, k};
  }
  return {};
}

struct Crossing {
  Side a, b;
};

/// `use(x, y, crossing)` for every empty cell between covered ones of two keyframes, by the shortest way across.
template <typename Use>
void for_each_seam_cell(const host::Raster<std::uint16_t>& source, Use use) {
  for (std::int32_t y = 0; y < source.height; ++y) {
    for (std::int32_t x = 0; x < source.width; ++x) {
      if (source.at(x, y) != 0) continue;
      Crossing best;
      for (const auto& [dx, dy] : directions) {
        const Crossing crossing{covered_towards(source, x, y, dx, dy), covered_towards(source, x, y, -dx, -dy)};
        if (crossing.a.cells == 0 || crossing.b.cells == 0) continue;
        if (source.at(crossing.a.x, crossing.a.y) == source.at(crossing.b.x, crossing.b.y)) continue;
        const bool shorter = crossing.a.cells + crossing.b.cells < best.a.cells + best.b.cells;
        if (best.a.cells == 0 || shorter) best = crossing;
      }
      if (best.a.cells != 0) use(x, y, best);
    }
  }
}

}  // namespace

void close_seams(GroundGrid& grid) {
  const host::Raster<std::uint16_t> source = grid.source;
  for_each_seam_cell(source, [&](std::int32_t x, std::int32_t y, const Crossing& crossing) {
    const auto [a, b] = crossing;
    const double za = grid.height.at(a.x, a.y), zb = grid.height.at(b.x, b.y);
    const double way = std::hypot(a.x - b.x, a.y - b.y) * grid.cell;
    if (!(std::fabs(za - zb) <= max_slope * way)) return;
    const double share = static_cast<double>(a.cells) / (a.cells + b.cells);
    grid.height.at(x, y) = static_cast<float>(za + share * (zb - za));
    const double grey = grid.ortho.at(a.x, a.y) + share * (grid.ortho.at(b.x, b.y) - grid.ortho.at(a.x, a.y));
    grid.ortho.at(x, y) = static_cast<std::uint8_t>(grey + 0.5);
    grid.source.at(x, y) = source.at(share < 0.5 ? a.x : b.x, share < 0.5 ? a.y : b.y);
  });
}

}  // namespace ilp::map
