#include "sim/world/sun.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "fsw/base/math.hpp"
#include "sim/world/lattice_noise.hpp"

namespace ilp::world {

Sunlight::Sunlight(double azimuth_rad, double elevation_rad, double spacing_m, double height_range_m)
    : spacing_m_(spacing_m) {
  const double x = det_cos(azimuth_rad);
  const double y = det_sin(azimuth_rad);
  sun_ = Vec3(det_cos(elevation_rad) * x, det_cos(elevation_rad) * y, det_sin(elevation_rad));
  along_x_ = std::fabs(x) >= std::fabs(y);
  const double major = along_x_ ? x : y;
  direction_ = major < 0 ? -1 : 1;
  drift_ = (along_x_ ? y : x) / std::fabs(major);
  rise_m_ = spacing_m / std::fabs(major) * det_sin(elevation_rad) / std::max(det_cos(elevation_rad), 1e-9);
  steps_ = static_cast<std::int32_t>(std::clamp(std::ceil(height_range_m / rise_m_), 1.0, 1.0 * longest_shadow));

  std::int32_t& ahead =
      along_x_ ? (direction_ > 0 ? margin_.right : margin_.left) : (direction_ > 0 ? margin_.above : margin_.below);
  ahead = steps_;
  const auto aside = static_cast<std::int32_t>(std::ceil(steps_ * std::fabs(drift_))) + 1;
  std::int32_t& beside =
      along_x_ ? (drift_ > 0 ? margin_.above : margin_.below) : (drift_ > 0 ? margin_.right : margin_.left);
  beside = aside;
}

double Sunlight::facing(double slope_x, double slope_y) const {
  const double cosine =
      (sun_.z() - sun_.x() * slope_x - sun_.y() * slope_y) / std::sqrt(1 + slope_x * slope_x + slope_y * slope_y);
  return std::max(0.0, cosine) / sun_.z();
}

Sunlight::Blocks Sunlight::blocks_of(std::span<const double> heights, std::int32_t columns, std::int32_t rows) {
  Blocks blocks;
  blocks.columns = (columns - 1) / Blocks::side + 1;
  const std::int32_t block_rows = (rows - 1) / Blocks::side + 1;
  constexpr double lowest = std::numeric_limits<double>::lowest();
  blocks.highest.assign(static_cast<std::size_t>(blocks.columns) * static_cast<std::size_t>(block_rows), lowest);
  const double* post = heights.data();
  for (std::int32_t j = 0; j < rows; ++j) {
    double* const row = blocks.highest.data() +
                        static_cast<std::ptrdiff_t>(j / Blocks::side) * static_cast<std::ptrdiff_t>(blocks.columns);
    for (std::int32_t i = 0; i < columns; ++i) row[i / Blocks::side] = std::max(row[i / Blocks::side], *post++);
  }
  blocks.top = *std::max_element(blocks.highest.begin(), blocks.highest.end());
  return blocks;
}

double Sunlight::highest_ahead(const Blocks& blocks, const Chunk& chunk, std::int32_t first, std::int32_t last) const {
  const std::int32_t ahead0 = direction_ > 0 ? first : -last;
  const std::int32_t ahead1 = direction_ > 0 ? last : -first;
  const std::int32_t aside0 = floor_to_int(std::min(first * drift_, last * drift_));
  const std::int32_t aside1 = floor_to_int(std::max(first * drift_, last * drift_)) + 1;
  const std::int32_t i0 = chunk.column + (along_x_ ? ahead0 : aside0);
  const std::int32_t i1 = chunk.column + chunk.count - 1 + (along_x_ ? ahead1 : aside1);
  const std::int32_t j0 = chunk.row + (along_x_ ? aside0 : ahead0);
  const std::int32_t j1 = chunk.row + (along_x_ ? aside1 : ahead1);
  double highest = std::numeric_limits<double>::lowest();
  for (std::int32_t j = j0 / Blocks::side; j <= j1 / Blocks::side; ++j) {
    for (std::int32_t i = i0 / Blocks::side; i <= i1 / Blocks::side; ++i) {
      highest =
          std::max(highest, blocks.highest[static_cast<std::size_t>(j) * static_cast<std::size_t>(blocks.columns) +
                                           static_cast<std::size_t>(i)]);
    }
  }
  return highest;
}

void Sunlight::raise_horizon(const double* heights, std::int32_t columns, std::int32_t step, Chunk& chunk) const {
  const auto stride = static_cast<std::ptrdiff_t>(columns);
  const double aside = step * drift_;
  const std::int32_t before = floor_to_int(aside);
  const double weight = aside - before;
  const std::int32_t ahead = step * direction_;
  const std::ptrdiff_t column = chunk.column + (along_x_ ? ahead : before);
  const std::ptrdiff_t row = chunk.row + (along_x_ ? before : ahead);
  const double* const a = heights + row * stride + column;
  const double* const b = a + (along_x_ ? stride : 1);
  const double drop = step * rise_m_;
  for (std::int32_t k = 0; k < chunk.count; ++k) {
    const double height = a[k] + (b[k] - a[k]) * weight - drop;
    chunk.horizon[k] = std::max(chunk.horizon[k], height);
  }
}

void Sunlight::find_horizon(const double* heights, std::int32_t columns, const Blocks& blocks, Chunk& chunk) const {
  // Heights below the post itself do not shade it.
  std::copy_n(heights + static_cast<std::ptrdiff_t>(chunk.row) * static_cast<std::ptrdiff_t>(columns) + chunk.column,
              chunk.count, chunk.horizon);
  constexpr std::int32_t run = Blocks::side;
  for (std::int32_t first = 1; first <= steps_; first += run) {
    const std::int32_t last = std::min(first + run - 1, steps_);
    const double lowest = *std::min_element(chunk.horizon, chunk.horizon + chunk.count);
    if (blocks.top - first * rise_m_ <= lowest) break;
    if (highest_ahead(blocks, chunk, first, last) - first * rise_m_ <= lowest) continue;
    for (std::int32_t step = first; step <= last; ++step) raise_horizon(heights, columns, step, chunk);
  }
}

void Sunlight::direct(std::span<const double> heights, std::int32_t columns, std::int32_t rows,
                      std::vector<double>& light) const {
  const Blocks blocks = blocks_of(heights, columns, rows);
  const double per_slope = 1 / (2 * spacing_m_);
  light.clear();
  Chunk chunk;
  for (chunk.row = margin_.below; chunk.row < rows - margin_.above; ++chunk.row) {
    const std::int32_t end = columns - margin_.right;
    for (chunk.column = margin_.left; chunk.column < end; chunk.column += Chunk::length) {
      chunk.count = std::min(Chunk::length, end - chunk.column);
      find_horizon(heights.data(), columns, blocks, chunk);
      const double* const post =
          heights.data() + static_cast<std::ptrdiff_t>(chunk.row) * static_cast<std::ptrdiff_t>(columns) + chunk.column;
      for (std::int32_t k = 0; k < chunk.count; ++k) {
        const double slope_x = (post[k + 1] - post[k - 1]) * per_slope;
        const double slope_y = (post[k + columns] - post[k - columns]) * per_slope;
        const double shadow = std::min(1.0, (chunk.horizon[k] - post[k]) / spacing_m_);
        light.push_back(facing(slope_x, slope_y) * (1 - shadow));
      }
    }
  }
}

}  // namespace ilp::world
