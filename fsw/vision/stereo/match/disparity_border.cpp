#include "fsw/vision/stereo/match/disparity_border.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"

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
    const std::uint8_t* beside = column.data() + k;
    for (std::int32_t x = radius; x < end; ++x) inner[static_cast<std::size_t>(x)] &= beside[x];
  }
}

struct InnerRow {
  const std::uint8_t* left;
  const std::uint8_t* right;
  std::int32_t width;

  [[nodiscard]] std::int32_t target_of(std::int32_t x, float disparity) const {
    // Made positive before truncation to a whole number, which rounds without a call of floor.
    constexpr std::int32_t lift = 4 * limits::max_rectified_width;
    const float lifted = static_cast<float>(x + lift) - disparity + 0.5F;
    return static_cast<std::int32_t>(lifted) - lift;
  }
  [[nodiscard]] bool holds(std::int32_t x, float disparity) const {
    if (left[x] == 0) return false;
    const std::int32_t target = target_of(x, disparity);
    return target >= 0 && target < width && right[target] != 0;
  }
};

struct Span {
  std::int32_t begin = 0, end = 0;
};

/// Inner columns of the right image without a gap: nearly always all there are.
Span safe_span(const InnerRow& row) {
  const auto find = [&row](std::int32_t from, int value) {
    const void* found = std::memchr(row.right + from, value, static_cast<std::size_t>(row.width - from));
    return found == nullptr ? row.width : static_cast<std::int32_t>(static_cast<const std::uint8_t*>(found) - row.right);
  };
  const std::int32_t begin = find(0, 1);
  return {begin, find(begin, 0)};
}

InnerRow inner_row(BorderWorkspace& w, std::int32_t y, std::int32_t width) {
  return {row_of(w.left_inner, y).data(), row_of(w.right_inner, y).data(), width};
}

/// Whether the median of the inner pixels is further away than the step: more than half of them lie on one side.
bool contradicted(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t x, std::int32_t y,
                  float step_px, BorderWorkspace& w) {
  const float lowest = disparity_px.at(x, y) - step_px;
  const float highest = disparity_px.at(x, y) + step_px;
  std::int32_t below = 0;
  std::int32_t about = 0;
  std::int32_t above = 0;
  const std::int32_t last_row = std::min(y + border_reach, sigma_px.height - 1);
  const std::int32_t last_column = std::min(x + border_reach, sigma_px.width - 1);
  for (std::int32_t v = std::max(y - border_reach, 0); v <= last_row; ++v) {
    const InnerRow inner = inner_row(w, v, sigma_px.width);
    for (std::int32_t u = std::max(x - border_reach, 0); u <= last_column; ++u) {
      const float d = disparity_px.at(u, v);
      if (!(sigma_px.at(u, v) > 0) || !inner.holds(u, d)) continue;
      below += d < lowest ? 1 : 0;
      above += d > highest ? 1 : 0;
      ++about;
    }
  }
  return 2 * below > about || 2 * above > about;
}

void check_border(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                  ImageView<const float> disparity_px, const ImageView<float>& sigma_px, BorderWorkspace& w) {
  const std::int32_t first = y == 0 ? 0 : y + border_reach;
  for (std::int32_t v = first; v <= y + border_reach && v < sigma_px.height; ++v) {
    find_inner(left_valid, params.window_radius, v, w.column, row_of(w.left_inner, v));
    find_inner(right_valid, params.window_radius, v, w.column, row_of(w.right_inner, v));
  }
  const auto step_px = static_cast<float>(params.border_step_px);
  const InnerRow inner = inner_row(w, y, sigma_px.width);
  const Span span = safe_span(inner);
  const float* disparity = disparity_px.row(y);
  float* sigma = sigma_px.row(y);
  const auto doubtful = [=](std::int32_t x) {
    const std::int32_t target = inner.target_of(x, disparity[x]);
    const int safe = static_cast<int>(inner.left[x] != 0) & static_cast<int>(target >= span.begin) &
                     static_cast<int>(target < span.end);
    return static_cast<int>(sigma[x] > 0) & (safe ^ 1);
  };
  for_each_flagged(0, sigma_px.width, doubtful, [&](std::int32_t x) {
    if (inner.holds(x, disparity[x])) return;
    if (contradicted(disparity_px, sigma_px, x, y, step_px, w)) sigma[x] = 0;
  });
}

}  // namespace

void check_border_row(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                      ImageView<const float> disparity_px, const ImageView<float>& sigma_px, BorderWorkspace& w) {
  with_widest_vectors([&] { check_border(left_valid, right_valid, params, y, disparity_px, sigma_px, w); });
}

}  // namespace ilp
