#include "fsw/vision/stereo/match/disparity_border.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"

namespace ilp {
namespace {

constexpr std::int32_t kept_rows = 2 * border_reach + 1;

template <typename Rows>
auto& row_of(Rows& rows, std::int32_t y) {
  return rows[static_cast<std::size_t>(y % kept_rows)];
}

/// 1 where all rows from y - radius to y + radius are valid.
void find_valid_columns(MaskView valid, std::int32_t radius, std::int32_t y, std::uint8_t* __restrict column) {
  const std::int32_t width = valid.width;
  if (radius == 2) {
    const std::uint8_t *a = valid.row(y - 2), *b = valid.row(y - 1), *c = valid.row(y), *d = valid.row(y + 1),
                       *e = valid.row(y + 2);
    const auto is = [](std::uint8_t v) { return static_cast<int>(v != 0); };
    for (std::int32_t x = 0; x < width; ++x) {
      column[x] = static_cast<std::uint8_t>(is(a[x]) & is(b[x]) & is(c[x]) & is(d[x]) & is(e[x]));
    }
    return;
  }
  std::fill_n(column, width, std::uint8_t{1});
  for (std::int32_t v = y - radius; v <= y + radius; ++v) {
    const std::uint8_t* __restrict row = valid.row(v);
    for (std::int32_t x = 0; x < width; ++x) column[x] &= row[x] != 0 ? 1 : 0;
  }
}

void find_inner(MaskView valid, std::int32_t radius, std::int32_t y, BorderWorkspace::Row& column,
                BorderWorkspace::Row& inner) {
  const std::int32_t width = valid.width;
  std::fill_n(inner.begin(), width, std::uint8_t{0});
  if (y < radius || y >= valid.height - radius || width <= 2 * radius) return;
  find_valid_columns(valid, radius, y, column.data());
  const std::int32_t end = width - radius;
  std::uint8_t* __restrict out = inner.data();
  const std::uint8_t* __restrict in = column.data();
  if (radius == 2) {
    for (std::int32_t x = 2; x < end; ++x) {
      out[x] = static_cast<std::uint8_t>(in[x - 2] & in[x - 1] & in[x] & in[x + 1] & in[x + 2]);
    }
    return;
  }
  std::fill(out + radius, out + end, std::uint8_t{1});
  for (std::int32_t k = -radius; k <= radius; ++k) {
    for (std::int32_t x = radius; x < end; ++x) out[x] &= in[x + k];
  }
}

struct InnerRow {
  const std::uint8_t* left;
  const std::uint8_t* right;
  std::int32_t width;

  // Made positive before truncation to a whole number, which rounds without a call of floor.
  static constexpr std::int32_t lift = 4 * limits::max_rectified_width;

  [[nodiscard]] std::int32_t target_of(std::int32_t x, float disparity) const {
    const float lifted = static_cast<float>(x + lift) - disparity + 0.5F;
    return static_cast<std::int32_t>(lifted) - lift;
  }
  [[nodiscard]] bool holds(std::int32_t x, float disparity) const {
    if (left[x] == 0) return false;
    const std::int32_t target = target_of(x, disparity);
    return target >= 0 && target < width && right[target] != 0;
  }
};

BorderWorkspace::Span span_of(const BorderWorkspace::Row& inner, std::int32_t width) {
  const auto find = [&](std::int32_t from, int value) {
    const std::uint8_t* row = inner.data();
    const void* found = std::memchr(row + from, value, static_cast<std::size_t>(width - from));
    return found == nullptr ? width : static_cast<std::int32_t>(static_cast<const std::uint8_t*>(found) - row);
  };
  const std::int32_t begin = find(0, 1);
  const std::int32_t end = find(begin, 0);
  return {begin, end, find(end, 1) == width};
}

InnerRow inner_row(BorderWorkspace& w, std::int32_t y, std::int32_t width) {
  return {row_of(w.left_inner, y).data(), row_of(w.right_inner, y).data(), width};
}

constexpr std::int32_t group = 8;
constexpr std::int32_t window_columns = group + 2 * border_reach;
constexpr float not_inner = std::numeric_limits<float>::quiet_NaN();

/// The disparities of the inner pixels in the columns around a group of pixels; not_inner at all others. Column
/// `first` of the group is at border_reach.
struct WindowRow {
  // Whole windows that begin elsewhere, because the row ends, leave what is outside of it as it is.
  std::array<float, window_columns + 2 * group> padded;
  [[nodiscard]] float* columns() { return padded.data() + group; }
};

/// Takes the window_columns columns from `begin` on.
[[gnu::always_inline]] inline void take_inner(const InnerRow& row, const BorderWorkspace::Span& span,
                                              const float* __restrict disparity_px, const float* __restrict sigma_px,
                                              std::int32_t begin, float* __restrict out) {
  const float* __restrict d = disparity_px + begin;
  const float* __restrict s = sigma_px + begin;
  if (!span.all) {
    for (std::int32_t i = 0; i < window_columns; ++i) {
      out[i] = s[i] > 0 && row.holds(begin + i, d[i]) ? d[i] : not_inner;
    }
    return;
  }
  const std::uint8_t* __restrict left = row.left + begin;
  for (std::int32_t i = 0; i < window_columns; ++i) {
    const std::int32_t target = row.target_of(begin + i, d[i]);
    const bool inner = static_cast<int>(s[i] > 0) & static_cast<int>(left[i] != 0) &
                       static_cast<int>(target >= span.begin) & static_cast<int>(target < span.end);
    out[i] = inner ? d[i] : not_inner;
  }
}

/// Of a group of pixels: whether the median of the inner pixels around each is further away than the step, because
/// more than half of them lie on one side.
struct Contradicted {
  std::int32_t first = -group;
  std::array<std::uint8_t, group> pixels{};

  [[nodiscard]] bool has(std::int32_t x) const { return x < first + group; }
  [[nodiscard]] bool at(std::int32_t x) const { return pixels[static_cast<std::size_t>(x - first)] != 0; }
};

/// `first` is that of `group` columns of the row, which has at least window_columns.
[[gnu::always_inline]] inline Contradicted find_contradicted(ImageView<const float> disparity_px,
                                                             ImageView<const float> sigma_px, std::int32_t first,
                                                             std::int32_t y, float step_px, BorderWorkspace& w) {
  WindowRow window;
  window.padded.fill(not_inner);
  const std::int32_t begin = std::clamp(first - border_reach, 0, sigma_px.width - window_columns);
  float* const taken = window.columns() + (begin - (first - border_reach));
  using Floats [[gnu::vector_size(sizeof(float) * group)]] = float;
  using Counts [[gnu::vector_size(sizeof(float) * group)]] = std::int32_t;
  Floats own;
  std::memcpy(&own, disparity_px.row(y) + first, sizeof own);
  const Floats lowest = own - step_px, highest = own + step_px;
  Counts below{}, about{}, above{};
  const std::int32_t last_row = std::min(y + border_reach, sigma_px.height - 1);
  for (std::int32_t v = std::max(y - border_reach, 0); v <= last_row; ++v) {
    take_inner(inner_row(w, v, sigma_px.width), row_of(w.right_span, v), disparity_px.row(v), sigma_px.row(v), begin,
               taken);
    for (std::int32_t k = 0; k <= 2 * border_reach; ++k) {
      Floats beside;
      std::memcpy(&beside, window.columns() + k, sizeof beside);
      below -= beside < lowest;
      above -= beside > highest;
      about -= beside == beside;
    }
  }
  Contradicted found;
  found.first = first;
  const Counts is_most = (2 * below > about) | (2 * above > about);
  for (std::size_t i = 0; i < group; ++i) found.pixels[i] = is_most[i] != 0 ? 1 : 0;
  return found;
}

/// The same for one pixel of a narrower image.
bool is_contradicted(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t x,
                     std::int32_t y, float step_px, BorderWorkspace& w) {
  const float lowest = disparity_px.at(x, y) - step_px;
  const float highest = disparity_px.at(x, y) + step_px;
  std::int32_t below = 0;
  std::int32_t about = 0;
  std::int32_t above = 0;
  const std::int32_t last_row = std::min(y + border_reach, sigma_px.height - 1);
  const std::int32_t last_column = std::min(x + border_reach, sigma_px.width - 1);
  for (std::int32_t v = std::max(y - border_reach, 0); v <= last_row; ++v) {
    const InnerRow inner = inner_row(w, v, sigma_px.width);
    const float* disparity = disparity_px.row(v);
    const float* sigma = sigma_px.row(v);
    for (std::int32_t u = std::max(x - border_reach, 0); u <= last_column; ++u) {
      if (!(sigma[u] > 0) || !inner.holds(u, disparity[u])) continue;
      below += disparity[u] < lowest ? 1 : 0;
      above += disparity[u] > highest ? 1 : 0;
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
    row_of(w.right_span, v) = span_of(row_of(w.right_inner, v), sigma_px.width);
  }
  const auto step_px = static_cast<float>(params.border_step_px);
  const InnerRow inner = inner_row(w, y, sigma_px.width);
  const BorderWorkspace::Span span = row_of(w.right_span, y);
  const float* disparity = disparity_px.row(y);
  float* sigma = sigma_px.row(y);
  const auto suspect = [=](std::int32_t x) {
    const std::int32_t target = inner.target_of(x, disparity[x]);
    const int safe = static_cast<int>(inner.left[x] != 0) & static_cast<int>(target >= span.begin) &
                     static_cast<int>(target < span.end);
    return static_cast<int>(sigma[x] > 0) & (safe ^ 1);
  };
  // What becomes empty is not inner, so that the pixels of a group do not depend on each other.
  Contradicted contradicted;
  for_each_flagged(0, sigma_px.width, suspect, [&](std::int32_t x) {
    if (inner.holds(x, disparity[x])) return;
    if (sigma_px.width < window_columns) {
      if (is_contradicted(disparity_px, sigma_px, x, y, step_px, w)) sigma[x] = 0;
      return;
    }
    if (!contradicted.has(x)) {
      contradicted = find_contradicted(disparity_px, sigma_px, std::min(x, sigma_px.width - group), y, step_px, w);
    }
    if (contradicted.at(x)) sigma[x] = 0;
  });
}

}  // namespace

void check_border_row(MaskView left_valid, MaskView right_valid, const StereoParams& params, std::int32_t y,
                      ImageView<const float> disparity_px, const ImageView<float>& sigma_px, BorderWorkspace& w) {
  with_widest_vectors([&] { check_border(left_valid, right_valid, params, y, disparity_px, sigma_px, w); });
}

}  // namespace ilp
