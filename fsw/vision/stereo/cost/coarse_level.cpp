#include "fsw/vision/stereo/cost/coarse_level.hpp"

#include <algorithm>
#include <array>

#include "cfg/limits.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

using Sums = std::array<std::uint16_t, static_cast<std::size_t>(limits::max_rectified_width)>;

/// Sums of coarse_step rows.
template <typename Value>
void add_rows(ImageView<const std::uint8_t> image, std::int32_t y, Value value, Sums& sums) {
  std::uint16_t* __restrict out = sums.data();
  std::fill_n(out, image.width, std::uint16_t{0});
  for (std::int32_t v = y * coarse_step; v < (y + 1) * coarse_step; ++v) {
    const std::uint8_t* __restrict row = image.row(v);
    for (std::int32_t x = 0; x < image.width; ++x) out[x] = static_cast<std::uint16_t>(out[x] + value(row[x]));
  }
}

template <typename Use>
void for_each_sum(const Sums& sums, std::int32_t width, Use use) {
  for (std::int32_t x = 0; x < width; ++x) {
    int sum = 0;
    const std::int32_t first = x * coarse_step;
    for (std::int32_t i = first; i < first + coarse_step; ++i) sum += sums[static_cast<std::size_t>(i)];
    use(x, sum);
  }
}

constexpr int coarse_area = coarse_step * coarse_step;

void reduce_grey(GrayView image, std::int32_t y, std::int32_t width, std::uint8_t* out) {
  Sums sums;
  add_rows(
      image, y, [](std::uint8_t grey) { return grey; }, sums);
  for_each_sum(sums, width, [&](std::int32_t x, int sum) {
    out[x] = static_cast<std::uint8_t>((sum + coarse_area / 2) / coarse_area);
  });
}

void reduce_mask(MaskView mask, std::int32_t y, std::int32_t width, std::uint8_t* out) {
  Sums sums;
  add_rows(
      mask, y, [](std::uint8_t valid) { return valid != 0 ? 1 : 0; }, sums);
  for_each_sum(sums, width, [&](std::int32_t x, int sum) { out[x] = sum == coarse_area ? 1 : 0; });
}

}  // namespace

CoarsePair make_coarse_pair(std::uint8_t* bytes, std::int32_t width, std::int32_t height) {
  const std::int32_t w = width / coarse_step;
  const std::int32_t h = height / coarse_step;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w) * h;
  return {{bytes, w, h}, {bytes + plane, w, h}, {bytes + 2 * plane, w, h}, {bytes + 3 * plane, w, h}};
}

void reduce_row(const StereoPairView& pair, std::int32_t y, const CoarsePair& coarse) {
  with_widest_vectors([&] {
    const std::int32_t width = coarse.left.width;
    reduce_grey(pair.left, y, width, coarse.left.row(y));
    reduce_grey(pair.right, y, width, coarse.right.row(y));
    reduce_mask(pair.left_valid, y, width, coarse.left_valid.row(y));
    reduce_mask(pair.right_valid, y, width, coarse.right_valid.row(y));
  });
}

}  // namespace ilp
