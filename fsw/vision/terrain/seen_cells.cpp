#include "fsw/vision/terrain/seen_cells.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/argument.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/terrain/sigma_map.hpp"

namespace ilp {
namespace {

constexpr std::int32_t sigma_classes = 4;
constexpr double finest_sigma_class = 0.0025;  // each further class ends at twice the sigma
static_assert(sampling_levels * sigma_classes <= 255);

struct Quality {
  std::int32_t sampling = 0, sigma = 0;
};

Quality quality_of(std::uint8_t byte) {
  return {(byte - 1) / sigma_classes, (byte - 1) % sigma_classes};
}

std::uint8_t byte_of(const Quality& quality) {
  const std::int32_t level = (quality.sampling % sampling_levels + sampling_levels) % sampling_levels;
  return static_cast<std::uint8_t>(1 + level * sigma_classes + quality.sigma);
}

/// Rounded to the nearest level, before it repeats.
std::int32_t level_of(double ratio) {
  constexpr double ln2 = 0.69314718055994530942;  // as det_log(2)
  const double octaves = det_log(ratio) / ln2;
  return static_cast<std::int32_t>(std::floor(sampling_levels_per_octave * std::clamp(octaves, -1e6, 1e6) + 0.5));
}

bool usable(double v) {
  return std::isfinite(v) && v > 0;
}

/// One pixel: sigma is 0 where there is no depth, inverse depth is 0 where it is not known.
struct SeenPixel {
  double inverse_depth = 0, sigma = 0;
};

struct SeenSum {
  std::int32_t matched = 0, known = 0;
  double inverse_depth = 0, sigma = 0;

  void add(const SeenPixel& pixel) {
    if (!(pixel.sigma > 0)) return;
    ++matched;
    sigma += pixel.sigma;
    if (!(pixel.inverse_depth > 0)) return;
    ++known;
    inverse_depth += pixel.inverse_depth;
  }
};

template <typename PixelAt>
SeenSum sum_of(std::int32_t x_begin, std::int32_t x_end, std::int32_t y_begin, std::int32_t y_end, PixelAt pixel_at) {
  SeenSum sum;
  for (std::int32_t y = y_begin; y < y_end; ++y) {
    for (std::int32_t x = x_begin; x < x_end; ++x) sum.add(pixel_at(x, y));
  }
  return sum;
}

template <typename PixelAt>
Status fill(std::int32_t width, std::int32_t height, double focal_px, std::int32_t min_pixels, PixelAt pixel_at,
            SeenCells& cells) {
  ILP_TRY(clear_seen_cells(width, height, cells));
  SeenSum all;
  bool summed = false;
  std::size_t cell = 0;
  for (std::int32_t y = 0; y < height; y += seen_cell_px) {
    for (std::int32_t x = 0; x < width; x += seen_cell_px, ++cell) {
      const SeenSum sum = sum_of(x, std::min(x + seen_cell_px, width), y, std::min(y + seen_cell_px, height), pixel_at);
      if (sum.matched < std::max(min_pixels, 1)) continue;
      if (sum.known == 0 && !summed) {
        all = sum_of(0, width, 0, height, pixel_at);
        summed = true;
        if (all.known == 0) return {};
      }
      const SeenSum& depth = sum.known > 0 ? sum : all;
      const double inverse_depth = depth.inverse_depth / depth.known;
      cells.quality[cell] = seen_quality(1 / (inverse_depth * focal_px), sum.sigma / sum.matched / inverse_depth);
    }
  }
  return {};
}

}  // namespace

std::uint8_t seen_quality(double sampling, double relative_sigma) {
  if (!usable(sampling) || !usable(relative_sigma)) return 0;
  Quality quality{level_of(sampling), 0};
  for (double limit = finest_sigma_class; quality.sigma + 1 < sigma_classes && relative_sigma > limit; limit *= 2) {
    ++quality.sigma;
  }
  return byte_of(quality);
}

std::int32_t sampling_steps(double ratio) {
  return usable(ratio) ? std::max(level_of(ratio), 1) : 1;
}

bool at_least_as_well(std::uint8_t seen, std::uint8_t now, std::int32_t finer_steps) {
  if (seen == 0) return false;
  if (now == 0) return true;
  const Quality before = quality_of(seen);
  const Quality after = quality_of(now);
  // The shorter way round the levels.
  std::int32_t finer = before.sampling - after.sampling;
  if (finer > sampling_levels / 2) finer -= sampling_levels;
  if (finer < -(sampling_levels / 2)) finer += sampling_levels;
  const bool smaller_error = sampling_levels_per_octave * (after.sigma - before.sigma) < finer;
  return finer < finer_steps || !smaller_error;
}

bool at_least_as_well(std::uint8_t seen, std::uint8_t now, double finer, double claim_ratio) {
  if (seen == 0) return false;
  if (finer < claim_ratio) return true;
  if (now == 0) return false;
  // Classes of the relative error are octaves.
  const std::int32_t octaves = quality_of(now).sigma - quality_of(seen).sigma;
  return octaves >= 0 ? finer <= (1 << octaves) : finer * (1 << -octaves) <= 1;
}

Status clear_seen_cells(std::int32_t width, std::int32_t height, SeenCells& cells) {
  if (width < 1 || height < 1 || width > limits::max_image_width || height > limits::max_image_height) {
    return {StatusCode::image_too_large, width, height};
  }
  cells.columns = seen_cells_side(width);
  cells.rows = seen_cells_side(height);
  cells.quality.fill(0);
  return {};
}

Status seen_cells(const StoredDepth& depth, double focal_px, std::int32_t min_pixels, SeenCells& cells) {
  if (!same_size(depth.codes, depth.sigma_codes)) return out_of_range(Argument::depth_size, depth.codes.width);
  if (!usable(focal_px) || !usable(depth.disparity_per_inverse_depth_px) || !usable(depth.coding.step) ||
      !std::isfinite(depth.coding.offset)) {
    return out_of_range(Argument::depth_coding, depth.coding.step);
  }
  const double sigma_step = 1 / (depth.disparity_per_inverse_depth_px * sigma_codes_per_px);
  const auto pixel_at = [&](std::int32_t x, std::int32_t y) {
    const std::uint16_t code = depth.codes.at(x, y);
    const int sigma = depth.sigma_codes.at(x, y) & sigma_code_largest;
    return SeenPixel{code == 0 ? 0 : depth.coding.offset + depth.coding.step * code, sigma * sigma_step};
  };
  return fill(depth.codes.width, depth.codes.height, focal_px, min_pixels, pixel_at, cells);
}

Status seen_cells(ImageView<const float> inverse_depth, ImageView<const float> sigma, double focal_px,
                  std::int32_t min_pixels, SeenCells& cells) {
  if (!same_size(inverse_depth, sigma)) return out_of_range(Argument::depth_size, sigma.width);
  if (!usable(focal_px)) return out_of_range(Argument::focal_length, focal_px);
  const auto pixel_at = [&](std::int32_t x, std::int32_t y) {
    return SeenPixel{static_cast<double>(inverse_depth.at(x, y)), static_cast<double>(sigma.at(x, y))};
  };
  return fill(sigma.width, sigma.height, focal_px, min_pixels, pixel_at, cells);
}

}  // namespace ilp
