#include "fsw/vision/stereo/rectify/rectification_residual.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

constexpr std::int32_t grid_px = 8;
constexpr std::int32_t radius = 3;
constexpr std::int32_t reach = VerticalResidual::max_px;
constexpr std::int32_t area = (2 * radius + 1) * (2 * radius + 1);
// Below these limits a window gives no information: standard deviation of grey, drop of the correlation one px from its
// best.
constexpr double min_deviation_grey = 3;
constexpr double min_drop = 0.01;

struct Moments {
  std::int32_t sum = 0, square = 0;

  [[nodiscard]] double variance_sum() const { return square - static_cast<double>(sum) * sum / area; }
};

/// Adds a row of a window about (x, y), or takes it out again.
void add_row(GrayView image, std::int32_t x, std::int32_t y, std::int32_t sign, Moments& m) {
  const std::uint8_t* const row = image.row(y) + x - radius;
  std::int32_t sum = 0, square = 0;
  for (std::int32_t i = 0; i < 2 * radius + 1; ++i) {
    sum += row[i];
    square += row[i] * row[i];
  }
  m.sum += sign * sum;
  m.square += sign * square;
}

Moments moments_at(GrayView image, std::int32_t x, std::int32_t y) {
  Moments m;
  for (std::int32_t j = y - radius; j <= y + radius; ++j) add_row(image, x, j, 1, m);
  return m;
}

double correlation(GrayView left, std::int32_t x, std::int32_t y, const Moments& at_left, GrayView right,
                   std::int32_t xr, std::int32_t yr, const Moments& at_right) {
  std::int32_t product = 0;
  for (std::int32_t j = -radius; j <= radius; ++j) {
    const std::uint8_t* const p = left.row(y + j) + x - radius;
    const std::uint8_t* const q = right.row(yr + j) + xr - radius;
    for (std::int32_t i = 0; i < 2 * radius + 1; ++i) product += p[i] * q[i];
  }
  const double covariance = product - static_cast<double>(at_left.sum) * at_right.sum / area;
  const double norm = at_left.variance_sum() * at_right.variance_sum();
  return norm > 0 ? covariance / std::sqrt(norm) : 0;
}

/// Absolute vertical distance of the match of left pixel (x, y) whose column in the right image is xr; negative: none.
double distance_of(GrayView left, std::int32_t x, std::int32_t y, GrayView right, std::int32_t xr) {
  const Moments here = moments_at(left, x, y);
  if (here.variance_sum() < area * min_deviation_grey * min_deviation_grey) return -1;
  double at[2 * reach + 1];
  int best = 0;
  Moments there = moments_at(right, xr, y - reach);
  for (int k = 0; k <= 2 * reach; ++k) {
    const std::int32_t yr = y + k - reach;
    at[k] = correlation(left, x, y, here, right, xr, yr, there);
    if (at[k] > at[best]) best = k;
    if (k == 2 * reach) break;
    add_row(right, xr, yr - radius, -1, there);
    add_row(right, xr, yr + radius + 1, 1, there);
  }
  if (best == 0 || best == 2 * reach) return reach;
  const double curvature = 2 * at[best] - at[best - 1] - at[best + 1];
  if (curvature < 2 * min_drop) return -1;
  return std::fabs(best - reach + 0.5 * (at[best + 1] - at[best - 1]) / curvature);
}

}  // namespace

double VerticalResidual::median_px() const {
  std::uint32_t below = 0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    below += histogram[bin];
    if (2 * below >= count && count > 0) return (static_cast<double>(bin) + 0.5) / bins_per_px;
  }
  return 0;
}

void add_vertical_residuals(GrayView left, GrayView right, MaskView right_valid, ImageView<const float> disparity_px,
                            ImageView<const float> disparity_sigma_px, VerticalResidual& residual) {
  constexpr std::int32_t border = radius + reach;
  for (std::int32_t y = grid_px; y < left.height - border; y += grid_px) {
    for (std::int32_t x = grid_px; x < left.width - radius; x += grid_px) {
      if (!(disparity_sigma_px.at(x, y) > 0)) continue;
      const auto xr = static_cast<std::int32_t>(std::floor(static_cast<float>(x) - disparity_px.at(x, y) + 0.5F));
      if (xr < radius || xr >= right.width - radius) continue;
      if (right_valid.at(xr, y - border) == 0 || right_valid.at(xr, y + border) == 0) continue;
      const double distance = distance_of(left, x, y, right, xr);
      if (distance < 0) continue;
      const auto bin = static_cast<std::size_t>(distance * VerticalResidual::bins_per_px);
      ++residual.histogram[std::min(bin, residual.histogram.size() - 1)];
      ++residual.count;
    }
  }
}

}  // namespace ilp
