#include "fsw/vision/stereo/disparity_border.hpp"

#include <algorithm>
#include <cmath>

namespace ilp {
namespace {

constexpr std::int32_t kept_rows = 2 * border_reach + 1;
using Rows = std::array<BorderWorkspace::Row, kept_rows>;

BorderWorkspace::Row& row_of(Rows& rows, std::int32_t y) {
  return rows[static_cast<std::size_t>(y % kept_rows)];
}

void find_inner(MaskView valid, std::int32_t radius, std::int32_t y, BorderWorkspace::Row& column,
                BorderWorkspace::Row& inner) {
  const std::int32_t width = valid.width;
  inner.fill(0);
  if (y < radius || y >= valid.height - radius || width <= 2 * radius) return;
  column.fill(1);
  for (std::int32_t v = y - radius; v <= y + radius; ++v) {
    const std::uint8_t* __restrict row = valid.row(v);
    for (std::int32_t x = 0; x < width; ++x) column[static_cast<std::size_t>(x)] &= row[x] != 0 ? 1 : 0;
  }
  const std::int32_t end = width - radius;
  std::fill(inner.begin() + radius, inner.begin() + end, std::uint8_t{1});
  for (std::int32_t k = -radius; k <= radius; ++k) {
    for (std::int32_t x = radius; x < end; ++x) {
      inner[static_cast<std::size_t>(x)] &= column[static_cast<std::size_t>(x + k)];
    }
  }
}

bool is_inner(BorderWorkspace& w, std::int32_t width, std::int32_t x, std::int32_t y, float disparity) {
  if (row_of(w.left_inner, y)[static_cast<std::size_t>(x)] == 0) return false;
  const auto target = static_cast<std::int32_t>(std::floor(static_cast<float>(x) - disparity + 0.5F));
  return target >= 0 && target < width && row_of(w.right_inner, y)[static_cast<std::size_t>(target)] != 0;
}

/// False when there are no inner pixels about.
bool inner_median(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t x, std::int32_t y,
                  BorderWorkspace& w, float& median) {
  std::array<float, static_cast<std::size_t>(kept_rows) * kept_rows> found;
  std::ptrdiff_t count = 0;
  const std::int32_t last_row = std::min(y + border_reach, sigma_px.height - 1);
  const std::int32_t last_column = std::min(x + border_reach, sigma_px.width - 1);
  for (std::int32_t v = std::max(y - border_reach, 0); v <= last_row; ++v) {
    for (std::int32_t u = std::max(x - border_reach, 0); u <= last_column; ++u) {
      const float d = disparity_px.at(u, v);
      if (sigma_px.at(u, v) > 0 && is_inner(w, sigma_px.width, u, v, d)) found[static_cast<std::size_t>(count++)] = d;
    }
  }
  if (count == 0) return false;
  std::nth_element(found.begin(), found.begin() + count / 2, found.begin() + count);
  median = found[static_cast<std::size_t>(count / 2)];
  return true;
}

}  // namespace

void check_border_row(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                      ImageView<const float> disparity_px, const ImageView<float>& sigma_px, BorderWorkspace& w) {
  const std::int32_t first = y == 0 ? 0 : y + border_reach;
  for (std::int32_t v = first; v <= y + border_reach && v < sigma_px.height; ++v) {
    find_inner(left_valid, params.window_radius, v, w.column, row_of(w.left_inner, v));
    find_inner(right_valid, params.window_radius, v, w.column, row_of(w.right_inner, v));
  }
  const auto step_px = static_cast<float>(params.border_step_px);
  for (std::int32_t x = 0; x < sigma_px.width; ++x) {
    const float d = disparity_px.at(x, y);
    if (!(sigma_px.at(x, y) > 0) || is_inner(w, sigma_px.width, x, y, d)) continue;
    float median = 0;
    if (inner_median(disparity_px, sigma_px, x, y, w, median) && std::fabs(d - median) > step_px) {
      sigma_px.at(x, y) = 0;
    }
  }
}

}  // namespace ilp
