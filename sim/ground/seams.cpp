#include "sim/ground/seams.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "sim/ground/statistics.hpp"

namespace ilp::ground {
namespace {

constexpr std::int32_t max_gap_cells = 2;
// Heights on both sides of a seam differ by no more than a wall of 76 degrees would (MergeParams::max_depth_jump).
constexpr double max_slope = 4;
constexpr std::array<std::array<std::int32_t, 2>, 4> directions = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};

struct Side {
  std::int32_t x = 0, y = 0, cells = 0;  ///< distance
};

/// The nearest covered cell that way, at most max_gap_cells off; cells 0: none.
Side covered_towards(const Raster<std::uint16_t>& source, std::int32_t x, std::int32_t y, std::int32_t dx,
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
void for_each_seam_cell(const Raster<std::uint16_t>& source, Use use) {
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

/// Logarithms of the ratio of brightness across the seam of two keyframes.
using SeamRatios = std::map<std::pair<std::uint16_t, std::uint16_t>, std::vector<double>>;

SeamRatios seam_ratios(const GroundGrid& grid) {
  SeamRatios ratios;
  constexpr double darkest = 8;  // below, rounding to whole grey levels is most of the ratio
  const auto add = [&](std::int32_t xa, std::int32_t ya, std::int32_t xb, std::int32_t yb) {
    std::uint16_t a = grid.source.at(xa, ya), b = grid.source.at(xb, yb);
    double grey_a = grid.ortho.at(xa, ya), grey_b = grid.ortho.at(xb, yb);
    if (a == b || a == 0 || b == 0 || grey_a < darkest || grey_b < darkest) return;
    if (a > b) {
      std::swap(a, b);
      std::swap(grey_a, grey_b);
    }
    ratios[{a, b}].push_back(std::log(grey_a / grey_b));
  };
  // Pieces that touch have no empty cell between them: any two cells a short way apart will do.
  constexpr std::int32_t apart = max_gap_cells + 1;
  for (std::int32_t y = 0; y < grid.source.height; ++y) {
    for (std::int32_t x = 0; x < grid.source.width; ++x) {
      if (x + apart < grid.source.width) add(x, y, x + apart, y);
      if (y + apart < grid.source.height) add(x, y, x, y + apart);
    }
  }
  return ratios;
}

/// Of the logarithms, by source; a weak prior of no change settles what no seam ties down.
Eigen::VectorXd solve_gains(const SeamRatios& ratios, Eigen::Index sources) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(sources, sources) * 1e-3;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(sources);
  constexpr std::size_t fewest = 20;
  for (const auto& [pair, samples] : ratios) {
    if (samples.size() < fewest) continue;
    const Eigen::Index a = pair.first - 1, b = pair.second - 1;
    const auto weight = static_cast<double>(samples.size());
    // gain_b - gain_a = log(grey_a / grey_b)
    const double ratio = median(samples);
    normal(a, a) += weight;
    normal(b, b) += weight;
    normal(a, b) -= weight;
    normal(b, a) -= weight;
    right(a) -= weight * ratio;
    right(b) += weight * ratio;
  }
  return normal.ldlt().solve(right);
}

}  // namespace

void close_seams(GroundGrid& grid) {
  const Raster<std::uint16_t> source = grid.source;
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

void balance_exposure(GroundGrid& grid) {
  std::uint16_t sources = 0;
  for (const std::uint16_t s : grid.source.samples) sources = std::max(sources, s);
  if (sources < 2) return;
  Eigen::VectorXd gains = solve_gains(seam_ratios(grid), sources);
  double sum = 0, cells = 0;
  for (const std::uint16_t s : grid.source.samples) {
    if (s == 0) continue;
    sum += gains(s - 1);
    ++cells;
  }
  gains = (gains.array() - sum / cells).exp();
  for (std::size_t i = 0; i < grid.ortho.samples.size(); ++i) {
    const std::uint16_t s = grid.source.samples[i];
    if (s == 0) continue;
    const double grey = grid.ortho.samples[i] * gains(s - 1) + 0.5;
    grid.ortho.samples[i] = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
  }
}

}  // namespace ilp::ground
