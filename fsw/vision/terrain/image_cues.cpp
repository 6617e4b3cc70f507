#include <algorithm>
#include <array>
#include <cmath>

#include "fsw/base/math.hpp"
#include "fsw/vision/terrain/richness_cues.hpp"

namespace ilp {
namespace {

constexpr std::int32_t cell = richness_cell_px;
constexpr std::int32_t surround_radius = 4;

struct GreySum {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  [[nodiscard]] double mean() const { return count == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(count); }
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

/// Mean of |grad g|^2 by central differences over two pixels.
double fine_gradient_energy(GrayView image, MaskView mask) {
  std::int64_t energy = 0;
  std::int64_t count = 0;
  for (std::int32_t y = 1; y + 1 < image.height; ++y) {
    const std::uint8_t* a = image.row(y - 1);
    const std::uint8_t* b = image.row(y);
    const std::uint8_t* c = image.row(y + 1);
    const std::uint8_t* ma = mask.row(y - 1);
    const std::uint8_t* mb = mask.row(y);
    const std::uint8_t* mc = mask.row(y + 1);
    std::int32_t row_energy = 0;
    std::int32_t row_count = 0;
    for (std::int32_t x = 1; x + 1 < image.width; ++x) {
      const std::int32_t dx = b[x + 1] - b[x - 1];
      const std::int32_t dy = c[x] - a[x];
      const bool inside = mb[x - 1] != 0 && mb[x] != 0 && mb[x + 1] != 0 && ma[x] != 0 && mc[x] != 0;
      row_energy += inside ? dx * dx + dy * dy : 0;
      row_count += inside ? 1 : 0;
    }
    energy += row_energy;
    count += row_count;
  }
  return count == 0 ? 0 : static_cast<double>(energy) / (4 * static_cast<double>(count));
}

double entropy_bits(GrayView image, MaskView mask, const GreySum& total) {
  // Bins of g / G: the last takes everything from four times the mean.
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
    for (std::int32_t x = 0; x < image.width; ++x) {
      if (m[x] != 0) ++histogram[bin_of[g[x]]];
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

/// Mean grey of the masked pixels of every cell that is at least half inside.
void average_cells(GrayView image, MaskView mask, RichnessWorkspace& w) {
  const std::int32_t columns = image.width / cell;
  for (std::int32_t cy = 0; cy < image.height / cell; ++cy) {
    for (std::int32_t cx = 0; cx < columns; ++cx) {
      std::int32_t sum = 0;
      std::int32_t count = 0;
      for (std::int32_t y = cy * cell; y < (cy + 1) * cell; ++y) {
        for (std::int32_t x = cx * cell; x < (cx + 1) * cell; ++x) {
          if (mask.at(x, y) == 0) continue;
          sum += image.at(x, y);
          ++count;
        }
      }
      const auto i = static_cast<std::size_t>(cy * columns + cx);
      w.has_grey[i] = 2 * count >= cell * cell ? 1 : 0;
      w.grey[i] = w.has_grey[i] != 0 ? static_cast<float>(sum) / static_cast<float>(count) : 0.0F;
    }
  }
}

double coarse_gradient_energy(const RichnessWorkspace& w, std::int32_t columns, std::int32_t rows) {
  double energy = 0;
  std::int64_t count = 0;
  const auto stride = static_cast<std::size_t>(columns);
  for (std::int32_t cy = 1; cy + 1 < rows; ++cy) {
    for (std::int32_t cx = 1; cx + 1 < columns; ++cx) {
      const auto i = static_cast<std::size_t>(cy * columns + cx);
      const int inside =
          w.has_grey[i] & w.has_grey[i - 1] & w.has_grey[i + 1] & w.has_grey[i - stride] & w.has_grey[i + stride];
      if (inside == 0) continue;
      const double dx = static_cast<double>(w.grey[i + 1] - w.grey[i - 1]);
      const double dy = static_cast<double>(w.grey[i + stride] - w.grey[i - stride]);
      energy += 0.25 * (dx * dx + dy * dy);
      ++count;
    }
  }
  return count == 0 ? 0 : energy / static_cast<double>(count);
}

/// Mean square of (cell - surroundings) / surroundings, where the surroundings are at least a quarter known.
double surround_contrast_energy(const RichnessWorkspace& w, std::int32_t columns, std::int32_t rows) {
  constexpr std::int32_t side = 2 * surround_radius + 1;
  double energy = 0;
  std::int64_t count = 0;
  for (std::int32_t cy = 0; cy < rows; ++cy) {
    const std::int32_t top = std::max(cy - surround_radius, 0);
    const std::int32_t bottom = std::min(cy + surround_radius + 1, rows);
    for (std::int32_t cx = 0; cx < columns; ++cx) {
      const auto i = static_cast<std::size_t>(cy * columns + cx);
      if (w.has_grey[i] == 0) continue;
      const std::int32_t left = std::max(cx - surround_radius, 0);
      const std::int32_t right = std::min(cx + surround_radius + 1, columns);
      float sum = 0;
      std::int32_t known = 0;
      for (std::int32_t y = top; y < bottom; ++y) {
        for (std::int32_t x = left; x < right; ++x) {
          const auto k = static_cast<std::size_t>(y * columns + x);
          sum += w.grey[k];
          known += w.has_grey[k];
        }
      }
      if (4 * known < side * side || !(sum > 0)) continue;
      const double mean = static_cast<double>(sum) / known;
      const double relative = (static_cast<double>(w.grey[i]) - mean) / mean;
      energy += relative * relative;
      ++count;
    }
  }
  return count == 0 ? 0 : energy / static_cast<double>(count);
}

}  // namespace

void measure_image_cues(GrayView image, MaskView mask, double noise_grey, RichnessWorkspace& w, RichnessCues& cues) {
  const GreySum total = sum_grey(image, mask);
  const double mean = total.mean();
  if (!(mean > 0)) return;
  const std::int32_t columns = image.width / cell;
  const std::int32_t rows = image.height / cell;
  average_cells(image, mask, w);
  // White noise adds its variance to the energy of a central difference in both directions.
  const double noise = noise_grey * noise_grey;
  cues.gradient_fine = std::sqrt(std::max(0.0, fine_gradient_energy(image, mask) - noise)) / mean;
  const double cell_noise = noise / (cell * cell);
  cues.gradient_coarse = std::sqrt(std::max(0.0, coarse_gradient_energy(w, columns, rows) - cell_noise)) / mean;
  cues.entropy = entropy_bits(image, mask, total);
  cues.contrast = std::sqrt(surround_contrast_energy(w, columns, rows));
}

}  // namespace ilp
