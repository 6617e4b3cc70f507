#include "fsw/vision/stereo/rectify/rectification_residual.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/base/vector_width.hpp"

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

constexpr std::int32_t side = 2 * radius + 1;
constexpr std::int32_t padded_side = 8;
static_assert(side < padded_side);

/// Rows of a column of windows, with a zero behind each, so that a row is a vector.
template <std::int32_t Rows>
struct Column {
  alignas(16) std::int16_t grey[Rows][padded_side];

  Column(GrayView image, std::int32_t x, std::int32_t top) {
    for (std::int32_t j = 0; j < Rows; ++j) {
      const std::uint8_t* const row = image.row(top + j) + x - radius;
      for (std::int32_t i = 0; i < side; ++i) grey[j][i] = row[i];
      grey[j][side] = 0;
    }
  }

  /// Adds a row, or takes it out again.
  void add_row(std::int32_t j, std::int32_t sign, Moments& m) const {
    std::int32_t sum = 0, square = 0;
    for (std::int32_t i = 0; i < padded_side; ++i) {
      sum += grey[j][i];
      square += grey[j][i] * grey[j][i];
    }
    m.sum += sign * sum;
    m.square += sign * square;
  }
  /// Of the first window.
  [[nodiscard]] Moments moments() const {
    Moments m;
    for (std::int32_t j = 0; j < side; ++j) add_row(j, 1, m);
    return m;
  }
};
using LeftWindow = Column<side>;
using RightColumn = Column<side + 2 * reach>;

/// Of the left window and the right one whose first row is `top`.
double correlation(const LeftWindow& left, const Moments& at_left, const RightColumn& right, std::int32_t top,
                   const Moments& at_right) {
  const std::int16_t* const p = left.grey[0];
  const std::int16_t* const q = right.grey[top];
  std::int32_t product = 0;
  for (std::int32_t i = 0; i < side * padded_side; ++i) product += p[i] * q[i];
  const double covariance = product - static_cast<double>(at_left.sum) * at_right.sum / area;
  const double norm = at_left.variance_sum() * at_right.variance_sum();
  return norm > 0 ? covariance / std::sqrt(norm) : 0;
}

/// Absolute vertical distance of the match of left pixel (x, y) whose column in the right image is xr; negative: none.
double distance_of(GrayView left, std::int32_t x, std::int32_t y, GrayView right, std::int32_t xr) {
  const LeftWindow window(left, x, y - radius);
  const Moments here = window.moments();
  if (here.variance_sum() < area * min_deviation_grey * min_deviation_grey) return -1;
  const RightColumn column(right, xr, y - reach - radius);
  double at[2 * reach + 1];
  int best = 0;
  Moments there = column.moments();
  for (int k = 0; k <= 2 * reach; ++k) {
    at[k] = correlation(window, here, column, k, there);
    if (at[k] > at[best]) best = k;
    if (k == 2 * reach) break;
    column.add_row(k, -1, there);
    column.add_row(k + side, 1, there);
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

void add_vertical_residuals(GrayView left, GrayView right, MaskView right_valid, const DisparityView& map,
                            VerticalResidual& residual) {
  constexpr std::int32_t border = radius + reach;
  with_widest_vectors([&] {
    for (std::int32_t y = grid_px; y < left.height - border; y += grid_px) {
      for (std::int32_t x = grid_px; x < left.width - radius; x += grid_px) {
        if (!is_matched(map.kind.at(x, y))) continue;
        const auto xr = static_cast<std::int32_t>(std::floor(static_cast<float>(x) - map.disparity_px.at(x, y) + 0.5F));
        if (xr < radius || xr >= right.width - radius) continue;
        if (right_valid.at(xr, y - border) == 0 || right_valid.at(xr, y + border) == 0) continue;
        const double distance = distance_of(left, x, y, right, xr);
        if (distance < 0) continue;
        const auto bin = static_cast<std::size_t>(distance * VerticalResidual::bins_per_px);
        ++residual.histogram[std::min(bin, residual.histogram.size() - 1)];
        ++residual.count;
      }
    }
  });
}

}  // namespace ilp
