#include "fsw/vision/stereo/match/segment_filter.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/match/flagged_columns.hpp"

namespace ilp {
namespace {

/// By column, 0 or 1.
using Joined = std::array<std::uint8_t, static_cast<std::size_t>(limits::max_rectified_width)>;

[[gnu::always_inline]] inline int are_joined(float d, float s, float d_other, float s_other, float max_step_px) {
  return static_cast<int>(s > 0) & static_cast<int>(s_other > 0) &
         static_cast<int>(std::fabs(d - d_other) <= max_step_px);
}

/// Whether each pixel is joined to its left neighbour.
void find_joined(const float* __restrict d, const float* __restrict s, float max_step_px, std::int32_t width,
                 Joined& joined) {
  std::uint8_t* __restrict out = joined.data();
  out[0] = 0;
  for (std::int32_t x = 1; x < width; ++x) {
    out[x] = static_cast<std::uint8_t>(are_joined(d[x], s[x], d[x - 1], s[x - 1], max_step_px));
  }
}

/// Makes a tree of every run of joined pixels, whose first pixel has index `first` + its column.
void link_runs(const Joined& joined, std::int32_t width, std::int32_t first, std::int32_t* links) {
  for (std::int32_t begin = 0; begin < width;) {  // bound: the pixels of the row; a run has one or more
    const std::uint8_t* next = joined.data() + begin + 1;
    const void* gap = std::memchr(next, 0, static_cast<std::size_t>(width - begin - 1));
    const std::int32_t end =
        gap == nullptr ? width : static_cast<std::int32_t>(static_cast<const std::uint8_t*>(gap) - joined.data());
    links[first + begin] = begin - end;
    std::fill(links + first + begin + 1, links + first + end, first + begin);
    begin = end;
  }
}

void connect_segments(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t y,
                      float max_step_px, PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  const std::int32_t width = disparity_px.width;
  const std::int32_t first = y * width;
  Joined beside, beside_above;
  std::array<std::uint8_t, std::tuple_size_v<Joined> + 1> above;
  find_joined(disparity_px.row(y), sigma_px.row(y), max_step_px, width, beside);
  link_runs(beside, width, first, links);
  if (y == 0) return;
  find_joined(disparity_px.row(y - 1), sigma_px.row(y - 1), max_step_px, width, beside_above);
  const float* d = disparity_px.row(y);
  const float* s = sigma_px.row(y);
  const float* d_above = disparity_px.row(y - 1);
  const float* s_above = sigma_px.row(y - 1);
  // Column x is at x + 1, after one that is joined to nothing.
  std::uint8_t* __restrict joined_above = above.data();
  joined_above[0] = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    joined_above[x + 1] = static_cast<std::uint8_t>(are_joined(d[x], s[x], d_above[x], s_above[x], max_step_px));
  }
  // A pixel whose left neighbour has joined the same two runs joins nothing new.
  const auto joins = [joined_above, here = beside.data(), before = beside_above.data()](std::int32_t x) {
    return joined_above[x + 1] & ((joined_above[x] & here[x] & before[x]) ^ 1);
  };
  for_each_flagged(0, width, joins, [&](std::int32_t x) { join(links, first + x, first - width + x, 0); });
}

}  // namespace

void connect_segments_row(ImageView<const float> disparity_px, ImageView<const float> sigma_px, std::int32_t y,
                          float max_step_px, PixelForest& workspace) {
  with_widest_vectors([&] { connect_segments(disparity_px, sigma_px, y, max_step_px, workspace); });
}

namespace {

void remove_small_segments(const ImageView<float>& sigma_px, std::int32_t y, std::int32_t min_area_px,
                           PixelForest& workspace) {
  std::int32_t* links = workspace.links.data();
  const std::int32_t width = sigma_px.width;
  const std::int32_t first = y * width;
  float* s = sigma_px.row(y);
  // Pixels with the same parent have the same root.
  std::int32_t parent = -1;
  bool small = false;
  constexpr std::int32_t group = 16;
  const auto all_have_parent = [&](std::int32_t x) {
    std::int32_t differ = 0;
    for (std::int32_t i = x; i < x + group; ++i) differ |= links[first + i] ^ parent;
    return differ == 0;
  };
  for (std::int32_t x = 0; x < width;) {
    if (parent >= 0 && !small && x + group <= width && all_have_parent(x)) {
      x += group;
      continue;
    }
    for (const std::int32_t end = std::min(x + group, width); x < end; ++x) {
      if (!(s[x] > 0)) continue;
      const std::int32_t link = links[first + x];
      if (link < 0 || link != parent) small = -links[root_of(links, first + x)] < min_area_px;
      parent = link;
      if (small) s[x] = 0;
    }
  }
}

}  // namespace

void remove_small_segments_row(ImageView<float> sigma_px, std::int32_t y, std::int32_t min_area_px,
                               PixelForest& workspace) {
  with_widest_vectors([&] { remove_small_segments(sigma_px, y, min_area_px, workspace); });
}

}  // namespace ilp
