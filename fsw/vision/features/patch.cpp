#include "fsw/vision/features/patch.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/image/sampling.hpp"

namespace ilp {
namespace {

// All pixels have the same fractional position, so the weights are the same for the whole patch.
void sample_shifted(SmoothView image, FixedCoordinate x, FixedCoordinate y, std::int32_t side, std::int32_t* out) {
  const std::int32_t fx = (x >> 8) & 255, fy = (y >> 8) & 255;
  for (std::int32_t v = 0; v < side; ++v, out += side) {
    const std::uint16_t* const upper = image.row((y >> 16) + v) + (x >> 16);
    const std::uint16_t* const lower = upper + image.stride;
    for (std::int32_t u = 0; u < side; ++u) {
      const std::int32_t top = (upper[u] << 8) + fx * (upper[u + 1] - upper[u]);
      const std::int32_t bottom = (lower[u] << 8) + fx * (lower[u + 1] - lower[u]);
      out[u] = ((top << 8) + fy * (bottom - top)) >> 8;
    }
  }
}

/// A step from pixel to pixel of a patch, and one from row to row.
struct PatchSteps {
  FixedCoordinate xx, xy, yx, yy;
};

/// Two neighbours of a row, the left one in the lower half.
std::uint32_t load_pair(const std::uint16_t* at) {
  return at[0] | static_cast<std::uint32_t>(at[1]) << 16U;
}

/// Pixels that are sampled together: as many as of the largest patch with one more all around.
constexpr std::int32_t sampled_at_once = (limits::max_patch_side + 2) * (limits::max_patch_side + 2);
static_assert(max_sampled_side <= sampled_at_once);

// Only the loads go pixel by pixel.
void sample_rows(SmoothView image, FixedCoordinate x, FixedCoordinate y, const PatchSteps& step, std::int32_t side,
                 std::int32_t rows, std::int32_t* __restrict out) {
  std::int32_t offset[sampled_at_once], right[sampled_at_once], down[sampled_at_once];
  std::uint32_t upper[sampled_at_once], lower[sampled_at_once];
  const auto stride = static_cast<std::int32_t>(image.stride);
  for (std::int32_t v = 0, i = 0; v < rows; ++v, i += side) {
    const FixedCoordinate row_x = x + v * step.xy, row_y = y + v * step.yy;
    for (std::int32_t u = 0; u < side; ++u) {
      const FixedCoordinate px = row_x + u * step.xx, py = row_y + u * step.yx;
      right[i + u] = (px >> 8) & 255;
      down[i + u] = (py >> 8) & 255;
      offset[i + u] = (py >> 16) * stride + (px >> 16);
    }
  }
  const std::int32_t count = rows * side;
#pragma GCC unroll 1
  for (std::int32_t i = 0; i < count; ++i) {
    const std::uint16_t* const at = image.data + offset[i];
    upper[i] = load_pair(at);
    lower[i] = load_pair(at + stride);
  }
  const auto first = [](std::uint32_t pair) { return static_cast<std::int32_t>(pair & 0xFFFFU); };
  const auto second = [](std::uint32_t pair) { return static_cast<std::int32_t>(pair >> 16U); };
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t top = (first(upper[i]) << 8) + right[i] * (second(upper[i]) - first(upper[i]));
    const std::int32_t bottom = (first(lower[i]) << 8) + right[i] * (second(lower[i]) - first(lower[i]));
    out[i] = ((top << 8) + down[i] * (bottom - top)) >> 8;
  }
}

void sample_warped(SmoothView image, FixedCoordinate x, FixedCoordinate y, const PatchSteps& step, std::int32_t side,
                   std::int32_t* out) {
  const std::int32_t rows_at_once = sampled_at_once / side;
  for (std::int32_t v = 0; v < side; v += rows_at_once) {
    sample_rows(image, x + v * step.xy, y + v * step.yy, step, side, std::min(rows_at_once, side - v),
                out + std::ptrdiff_t{v} * side);
  }
}

}  // namespace

void smooth(GrayView image, ImageView<std::uint16_t> out) {
  for (std::int32_t y = 0; y < image.height; ++y) {
    const std::uint8_t* const above = image.row(std::max(y - 1, 0));
    const std::uint8_t* const here = image.row(y);
    const std::uint8_t* const below = image.row(std::min(y + 1, image.height - 1));
    std::uint16_t* const row = out.row(y);
    const auto column = [&](std::int32_t x) { return above[x] + 2 * here[x] + below[x]; };
    const std::int32_t last = image.width - 1;
    for (std::int32_t x = 1; x < last; ++x) {
      row[x] = static_cast<std::uint16_t>(column(x - 1) + 2 * column(x) + column(x + 1));
    }
    row[0] = static_cast<std::uint16_t>(3 * column(0) + column(std::min(1, last)));
    row[last] = static_cast<std::uint16_t>(3 * column(last) + column(std::max(last - 1, 0)));
  }
}

bool sample_patch(SmoothView image, float x, float y, const Linear2& warp, std::int32_t side, std::int32_t* out) {
  if (side < 1 || side > max_sampled_side) return false;
  const float half = 0.5F * static_cast<float>(side - 1);
  const float reach_x = half * (std::fabs(warp.xx) + std::fabs(warp.xy));
  const float reach_y = half * (std::fabs(warp.yx) + std::fabs(warp.yy));
  // A thousandth of a pixel for the rounding of the steps. The comparison is written so that NaN fails.
  constexpr float margin = 1e-3F;
  if (!(x - reach_x >= margin && x + reach_x <= static_cast<float>(image.width - 1) - margin)) return false;
  if (!(y - reach_y >= margin && y + reach_y <= static_cast<float>(image.height - 1) - margin)) return false;

  const FixedCoordinate xx = to_fixed(warp.xx), xy = to_fixed(warp.xy), yx = to_fixed(warp.yx), yy = to_fixed(warp.yy);
  const FixedCoordinate row_x = to_fixed(x - half * (warp.xx + warp.xy));
  const FixedCoordinate row_y = to_fixed(y - half * (warp.yx + warp.yy));
  const bool shifted = xx == 65536 && yy == 65536 && xy == 0 && yx == 0;
  with_widest_vectors([&] {
    if (shifted) {
      sample_shifted(image, row_x, row_y, side, out);
    } else {
      sample_warped(image, row_x, row_y, {xx, xy, yx, yy}, side, out);
    }
  });
  return true;
}

bool too_clipped(const std::int32_t* values, std::int32_t n) {
  // Smoothing and interpolation are exact in a uniform neighbourhood.
  constexpr std::int32_t white = 255 * 16 * 256;
  std::int32_t clipped = 0;
  for (std::int32_t i = 0; i < n; ++i) clipped += (values[i] <= 0 ? 1 : 0) + (values[i] >= white ? 1 : 0);
  return clipped * max_clipped_divisor > n;
}

bool extract_patch(SmoothView image, float x, float y, const Linear2& warp, std::int32_t side, float min_stddev,
                   NormalizedPatch& patch) {
  std::int32_t values[max_patch_pixels];
  if (!sample_patch(image, x, y, warp, side, values)) return false;
  const std::int32_t n = side * side;
  if (too_clipped(values, n)) return false;
  std::int32_t sum = 0;
  for (std::int32_t i = 0; i < n; ++i) sum += values[i];
  const std::int32_t whole_mean = sum / n;
  std::int64_t rest = 0, squares = 0;
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t d = (values[i] - whole_mean) >> 4;  // 16 bits, so that the square is a 32-bit product
    rest += d;
    const std::int32_t square = d * d;
    squares += square;
  }
  const double mean = static_cast<double>(sum) / n;
  const double variance =
      256 * (static_cast<double>(squares) - static_cast<double>(rest) * static_cast<double>(rest) / n);
  const double floor = 256.0 * static_cast<double>(smooth_units_per_grey * min_stddev);
  if (!(variance > n * floor * floor)) return false;
  const auto scale = static_cast<float>(16384.0 / std::sqrt(variance));
  const auto offset = static_cast<float>(mean);
  for (std::int32_t i = 0; i < n; ++i) {
    // Rounded to nearest by truncating a positive number, which vectorises where std::floor does not.
    const float value = (static_cast<float>(values[i]) - offset) * scale + 16384.5F;
    patch[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(static_cast<std::int32_t>(value) - 16384);
  }
  std::fill(patch.begin() + n, patch.begin() + static_cast<std::ptrdiff_t>(padded_count(side)), std::int16_t{0});
  return true;
}

std::int32_t correlate(const NormalizedPatch& p, const NormalizedPatch& q, std::int32_t side) {
  const std::size_t n = padded_count(side);
  std::int32_t sum = 0;
  for (std::size_t i = 0; i < n; ++i) sum += p[i] * q[i];
  return sum;
}

}  // namespace ilp
