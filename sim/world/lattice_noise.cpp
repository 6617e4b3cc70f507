#include "sim/world/lattice_noise.hpp"

#include <cstddef>
#include <vector>

namespace ilp::world {
namespace {

struct Gradient {
  double x, y;
};

// Eight directions of length sqrt(2), which brings the noise to [-1, 1].
constexpr double s = 1.41421356237309504880;
constexpr Gradient gradients[8] = {{1, 1}, {-1, 1}, {1, -1}, {-1, -1}, {s, 0}, {-s, 0}, {0, s}, {0, -s}};

Gradient gradient_at(std::int32_t i, std::int32_t j, std::uint32_t seed) {
  return gradients[lattice_hash(i, j, seed) >> 29U];
}

/// Columns that share a cell of the lattice.
struct Run {
  std::int32_t cell;
  std::size_t begin, end;
};

/// What is the same in every row.
struct Columns {
  std::vector<Run> runs;
  std::vector<double> u;       // place in the cell
  std::vector<double> weight;  // of the cell's far side
};

Columns columns_of(const Octave& octave, const PostGrid& grid, double cells_per_post) {
  Columns result;
  for (std::int32_t k = 0; k < grid.columns; ++k) {
    const double x = (grid.first_i + k) * cells_per_post + octave.offset_x;
    const std::int32_t cell = floor_to_int(x);
    const std::size_t here = result.u.size();
    if (result.runs.empty() || result.runs.back().cell != cell) result.runs.push_back({cell, here, here});
    result.runs.back().end = here + 1;
    result.u.push_back(x - cell);
    result.weight.push_back(quintic_fade(x - cell));
  }
  return result;
}

}  // namespace

void add_octave(const Octave& octave, const PostGrid& grid, std::span<double> values) {
  const double cells_per_post = grid.spacing_m / octave.wavelength_m;
  const Columns columns = columns_of(octave, grid, cells_per_post);
  const double* const us = columns.u.data();
  const double* const weights = columns.weight.data();
  double* row = values.data();
  for (std::int32_t j = 0; j < grid.rows; ++j, row += grid.columns) {
    const double y = (grid.first_j + j) * cells_per_post + octave.offset_y;
    const std::int32_t cell_y = floor_to_int(y);
    const double v = y - cell_y;
    const double weight_y = quintic_fade(v);
    for (const Run& run : columns.runs) {
      const Gradient a = gradient_at(run.cell, cell_y, octave.seed);
      const Gradient b = gradient_at(run.cell + 1, cell_y, octave.seed);
      const Gradient c = gradient_at(run.cell, cell_y + 1, octave.seed);
      const Gradient d = gradient_at(run.cell + 1, cell_y + 1, octave.seed);
      // The two ends of the cell, interpolated along y, are linear in u.
      const double left_slope = a.x + (c.x - a.x) * weight_y;
      const double right_slope = b.x + (d.x - b.x) * weight_y;
      const double left = a.y * v + (c.y * (v - 1) - a.y * v) * weight_y;
      const double right = b.y * v + (d.y * (v - 1) - b.y * v) * weight_y;
      for (std::size_t k = run.begin; k < run.end; ++k) {
        const double at_left = left + left_slope * us[k];
        const double at_right = right + right_slope * (us[k] - 1);
        row[k] += octave.amplitude * (at_left + (at_right - at_left) * weights[k]);
      }
    }
  }
}

}  // namespace ilp::world
