#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/terrain/richness_cues.hpp"

namespace ilp {
namespace {

constexpr std::int32_t half_cell = cell / 2;
constexpr std::int32_t tile = 4;  // cells
constexpr std::int32_t tile_stride = 2;

// Percentiles of the tiles, or spots, that represent the most striking and the ordinary ones. A feature seldom fills
// the newly seen part.
constexpr double striking_tiles = 0.97;
constexpr double ordinary_tiles = 0.1;
constexpr double striking_spots = 0.99;

// Smaller relative gradients and differences are ordinary in any case, so that no ratio has a denominator near zero.
constexpr double least_gradient = 0.004;
constexpr double least_spot = 0.0005;

struct GreySum {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  [[nodiscard]] double mean() const { return count == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(count); }
};

struct CellGrid {
  std::int32_t columns, rows;
  [[nodiscard]] std::size_t at(std::int32_t x, std::int32_t y) const {
    const std::int32_t index = y * columns + x;
    return static_cast<std::size_t>(index);
  }
};

GreySum sum_grey(GrayView image, MaskView mask) {
  GreySum s;
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* g = image.row(y);
    const std::uint8_t* m = mask.row(y);
    std::int32_t sum = 0;
    std::int32_t count = 0;
    for (std::int32_t x = 0; x < image.width; ++x) {
      sum += m[x] != 0 ? g[x] : 0;
      count += m[x] != 0 ? 1 : 0;
    }
    s.sum += sum;
    s.count += count;
  }
  return s;
}

double entropy_bits(GrayView image, MaskView mask, const GreySum& total) {
  // Bins of g / G; the last one includes everything from four times the mean.
  constexpr std::int64_t bins = limits::richness_histogram_bins;
  std::array<std::uint8_t, 256> bin_of{};
  for (std::int64_t grey = 0; grey < 256; ++grey) {
    const std::int64_t bin = total.sum == 0 ? 0 : grey * (bins / 4) * total.count / total.sum;
    bin_of[static_cast<std::size_t>(grey)] = static_cast<std::uint8_t>(std::min(bin, bins - 1));
  }
  std::array<std::uint32_t, limits::richness_histogram_bins> histogram{};
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* g = image.row(y);
    const std::uint8_t* m = mask.row(y);
    constexpr std::int32_t group = sizeof(std::uint64_t);
    for (std::int32_t begin = 0; begin < image.width; begin += group) {
      const std::int32_t end = std::min(begin + group, image.width);
      std::uint64_t inside = 1;
      if (end - begin == group) std::memcpy(&inside, m + begin, sizeof inside);
      // Most of an image has been seen before.
      if (inside == 0) continue;
      for (std::int32_t x = begin; x < end; ++x) {
        if (m[x] != 0) ++histogram[bin_of[g[x]]];
      }
    }
  }
  double entropy = 0;
  for (const std::uint32_t n : histogram) {
    if (n == 0) continue;
    const double p = n / static_cast<double>(total.count);
    entropy -= p * det_log(p);
  }
  return entropy / det_log(2.0);
}

/// Sums and counts of the masked pixels of every half cell.
void sum_half_cells(GrayView image, MaskView mask, RichnessWorkspace& w) {
  const CellGrid half{image.width / half_cell, image.height / half_cell};
  for (std::int32_t hy = 0; hy < half.rows; ++hy) {
    const std::uint8_t* g0 = image.row(hy * half_cell);
    const std::uint8_t* g1 = image.row(hy * half_cell + 1);
    const std::uint8_t* m0 = mask.row(hy * half_cell);
    const std::uint8_t* m1 = mask.row(hy * half_cell + 1);
    std::uint16_t* sum = &w.half_sum[half.at(0, hy)];
    std::uint8_t* count = &w.half_count[half.at(0, hy)];
    for (std::int32_t hx = 0; hx < half.columns; ++hx) {
      const std::int32_t x = hx * half_cell;
      const int a = m0[x] != 0 ? 1 : 0;
      const int b = m0[x + 1] != 0 ? 1 : 0;
      const int c = m1[x] != 0 ? 1 : 0;
      const int d = m1[x + 1] != 0 ? 1 : 0;
      sum[hx] = static_cast<std::uint16_t>(a * g0[x] + b * g0[x + 1] + c * g1[x] + d * g1[x + 1]);
      count[hx] = static_cast<std::uint8_t>(a + b + c + d);
    }
  }
}

/// Mean grey of every cell that is at least half inside.
void average_cells(const CellGrid& cells, std::int32_t half_columns, RichnessWorkspace& w) {
  for (std::int32_t cy = 0; cy < cells.rows; ++cy) {
    for (std::int32_t cx = 0; cx < cells.columns; ++cx) {
      const std::int32_t above = 2 * cy * half_columns + 2 * cx;
      const auto h = static_cast<std::size_t>(above);
      const auto below = h + static_cast<std::size_t>(half_columns);
      const int sum = w.half_sum[h] + w.half_sum[h + 1] + w.half_sum[below] + w.half_sum[below + 1];
      const int count = w.half_count[h] + w.half_count[h + 1] + w.half_count[below] + w.half_count[below + 1];
      const std::size_t i = cells.at(cx, cy);
      w.has_grey[i] = 2 * count >= cell * cell ? 1 : 0;
      w.grey[i] = w.has_grey[i] != 0 ? static_cast<float>(sum) / static_cast<float>(count) : 0.0F;
    }
  }
}

/// Mean over every cell of |grad g|^2 of the means of its half cells, by central differences over two of them, in
/// `energy`; `has_energy` where half of them have all neighbours wholly inside.
void fine_gradient_energy(const CellGrid& cells, const CellGrid& half, RichnessWorkspace& w) {
  constexpr std::int32_t pixels = half_cell * half_cell;
  const auto stride = static_cast<std::size_t>(half.columns);
  for (std::int32_t cy = 0; cy < cells.rows; ++cy) {
    for (std::int32_t cx = 0; cx < cells.columns; ++cx) {
      std::int32_t energy = 0;
      std::int32_t count = 0;
      for (std::int32_t y = std::max(1, 2 * cy); y < std::min(2 * cy + 2, half.rows - 1); ++y) {
        for (std::int32_t x = std::max(1, 2 * cx); x < std::min(2 * cx + 2, half.columns - 1); ++x) {
          const std::size_t i = half.at(x, y);
          const bool inside = w.half_count[i] == pixels && w.half_count[i - 1] == pixels &&
                              w.half_count[i + 1] == pixels && w.half_count[i - stride] == pixels &&
                              w.half_count[i + stride] == pixels;
          if (!inside) continue;
          const std::int32_t dx = w.half_sum[i + 1] - w.half_sum[i - 1];
          const std::int32_t dy = w.half_sum[i + stride] - w.half_sum[i - stride];
          energy += dx * dx + dy * dy;
          ++count;
        }
      }
      const std::size_t i = cells.at(cx, cy);
      w.has_energy[i] = count >= 2 ? 1 : 0;
      // Sums of four pixels, differences over two steps.
      w.energy[i] =
          w.has_energy[i] != 0 ? static_cast<float>(energy) / static_cast<float>(4 * pixels * pixels * count) : 0.0F;
    }
  }
}

/// The same of cell means, over two cells.
void coarse_gradient_energy(const CellGrid& cells, RichnessWorkspace& w) {
  const auto stride = static_cast<std::size_t>(cells.columns);
  for (std::int32_t cy = 0; cy < cells.rows; ++cy) {
    for (std::int32_t cx = 0; cx < cells.columns; ++cx) {
      const std::size_t i = cells.at(cx, cy);
      const bool border = cx == 0 || cy == 0 || cx + 1 == cells.columns || cy + 1 == cells.rows;
      w.has_energy[i] = border ? 0
                               : w.has_grey[i] & w.has_grey[i - 1] & w.has_grey[i + 1] & w.has_grey[i - stride] &
                                     w.has_grey[i + stride];
      if (w.has_energy[i] == 0) continue;
      const float dx = w.grey[i + 1] - w.grey[i - 1];
      const float dy = w.grey[i + stride] - w.grey[i - stride];
      w.energy[i] = 0.25F * (dx * dx + dy * dy);
    }
  }
}

/// Gradient of the most striking tiles over that of the ordinary ones: root of the ratio of their mean energies, with
/// `noise` subtracted from both. 1 when all are alike.
double gradient_ratio(const CellGrid& cells, double noise, double mean, RichnessWorkspace& w) {
  std::size_t count = 0;
  for (std::int32_t ty = 0; ty + tile <= cells.rows; ty += tile_stride) {
    for (std::int32_t tx = 0; tx + tile <= cells.columns; tx += tile_stride) {
      float sum = 0;
      int known = 0;
      for (std::int32_t y = ty; y < ty + tile; ++y) {
        for (std::int32_t x = tx; x < tx + tile; ++x) {
          const std::size_t i = cells.at(x, y);
          sum += w.has_energy[i] != 0 ? w.energy[i] : 0.0F;
          known += w.has_energy[i];
        }
      }
      if (2 * known >= tile * tile) w.buffer[count++] = sum / static_cast<float>(known);
    }
  }
  if (count == 0) return 1;
  const double least = least_gradient * mean * least_gradient * mean;
  const auto energy = [&](double share) {
    return std::max(0.0, quantile(w.buffer.data(), count, share) - noise) + least;
  };
  return std::sqrt(energy(striking_tiles) / energy(ordinary_tiles));
}

/// |half cell - mean of the 3x3 around it| / that mean; -1 where all of them are black.
void spots_of_row(const CellGrid& half, std::int32_t y, const RichnessWorkspace& w, float* __restrict spots) {
  const std::uint16_t* const s0 = &w.half_sum[half.at(0, y - 1)];
  const std::uint16_t* const s1 = &w.half_sum[half.at(0, y)];
  const std::uint16_t* const s2 = &w.half_sum[half.at(0, y + 1)];
  const std::uint8_t* const c0 = &w.half_count[half.at(0, y - 1)];
  const std::uint8_t* const c1 = &w.half_count[half.at(0, y)];
  const std::uint8_t* const c2 = &w.half_count[half.at(0, y + 1)];
  std::array<std::int32_t, static_cast<std::size_t>(limits::max_image_width / half_cell)> sums, counts;
  std::int32_t* const __restrict sum = sums.data();
  std::int32_t* const __restrict known = counts.data();
  for (std::int32_t x = 0; x < half.columns; ++x) sum[x] = s0[x] + s1[x] + s2[x];
  for (std::int32_t x = 0; x < half.columns; ++x) known[x] = c0[x] + c1[x] + c2[x];
  for (std::int32_t x = 1; x + 1 < half.columns; ++x) {
    const std::int32_t all = sum[x - 1] + sum[x] + sum[x + 1], pixels = known[x - 1] + known[x] + known[x + 1];
    const float mean = static_cast<float>(all) / static_cast<float>(pixels);
    const float here = static_cast<float>(s1[x]) / (half_cell * half_cell);
    spots[x] = all == 0 ? -1.0F : std::fabs(here - mean) / mean;
  }
}

/// |half cell - mean of the 3x3 around it| / that mean: its 99th percentile over its median. 3.8 for any Gaussian
/// pattern or noise; stones and their shadows give more.
double spot_contrast(const CellGrid& half, RichnessWorkspace& w) {
  std::size_t count = 0;
  std::array<float, static_cast<std::size_t>(limits::max_image_width / half_cell)> spots;
  for (std::int32_t y = 1; y + 1 < half.rows; ++y) {
    with_widest_vectors([&] { spots_of_row(half, y, w, spots.data()); });
    const std::uint8_t* const inside = &w.half_count[half.at(0, y)];
    for (std::int32_t x = 1; x + 1 < half.columns; ++x) {
      const float spot = spots[static_cast<std::size_t>(x)];
      if (inside[x] == half_cell * half_cell && spot >= 0) w.buffer[count++] = spot;
    }
  }
  if (count == 0) return 0;
  const double ordinary = quantile(w.buffer.data(), count, 0.5) + least_spot;
  return quantile(w.buffer.data(), count, striking_spots) / ordinary;
}

}  // namespace

double quantile(float* values, std::size_t count, double share) {
  if (count == 0) return 0;
  const std::size_t rank = std::min(count - 1, static_cast<std::size_t>(share * static_cast<double>(count)));
  std::nth_element(values, values + rank, values + count);
  return static_cast<double>(values[rank]);
}

void measure_image_cues(std::int32_t part, GrayView image, MaskView mask, double noise_grey, RichnessWorkspace& w,
                        RichnessCues& cues) {
  GreySum total;
  with_widest_vectors([&] { total = sum_grey(image, mask); });
  const double mean = total.mean();
  if (!(mean > 0)) return;
  const CellGrid cells{image.width / cell, image.height / cell};
  const CellGrid half{image.width / half_cell, image.height / half_cell};
  if (part != 0) {
    cues.entropy = entropy_bits(image, mask, total);
    cues.contrast = spot_contrast(half, w);
    return;
  }
  sum_half_cells(image, mask, w);
  average_cells(cells, half.columns, w);
  // White noise adds its variance to the energy of a central difference in both directions.
  const double noise = noise_grey * noise_grey;
  fine_gradient_energy(cells, half, w);
  cues.gradient_fine = gradient_ratio(cells, noise / (half_cell * half_cell), mean, w);
  coarse_gradient_energy(cells, w);
  cues.gradient_coarse = gradient_ratio(cells, noise / (cell * cell), mean, w);
}

}  // namespace ilp
