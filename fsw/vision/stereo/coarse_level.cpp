#include "fsw/vision/stereo/coarse_level.hpp"

namespace ilp {
namespace {

void halve_grey(GrayView image, std::int32_t y, std::int32_t width, std::uint8_t* __restrict out) {
  const std::uint8_t* __restrict above = image.row(2 * y);
  const std::uint8_t* __restrict below = image.row(2 * y + 1);
  for (std::int32_t x = 0; x < width; ++x) {
    out[x] = static_cast<std::uint8_t>((above[2 * x] + above[2 * x + 1] + below[2 * x] + below[2 * x + 1] + 2) >> 2);
  }
}

void halve_mask(MaskView mask, std::int32_t y, std::int32_t width, std::uint8_t* __restrict out) {
  const std::uint8_t* __restrict above = mask.row(2 * y);
  const std::uint8_t* __restrict below = mask.row(2 * y + 1);
  for (std::int32_t x = 0; x < width; ++x) {
    const bool left = above[2 * x] != 0 && below[2 * x] != 0;
    const bool right = above[2 * x + 1] != 0 && below[2 * x + 1] != 0;
    out[x] = left && right ? 1 : 0;
  }
}

}  // namespace

CoarsePair make_coarse_pair(std::uint8_t* bytes, std::int32_t width, std::int32_t height) {
  const std::int32_t w = width / 2;
  const std::int32_t h = height / 2;
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(w) * h;
  return {{bytes, w, h}, {bytes + plane, w, h}, {bytes + 2 * plane, w, h}, {bytes + 3 * plane, w, h}};
}

void halve_row(const StereoPairView& pair, std::int32_t y, const CoarsePair& coarse) {
  const std::int32_t width = coarse.left.width;
  halve_grey(pair.left, y, width, coarse.left.row(y));
  halve_grey(pair.right, y, width, coarse.right.row(y));
  halve_mask(pair.left_valid, y, width, coarse.left_valid.row(y));
  halve_mask(pair.right_valid, y, width, coarse.right_valid.row(y));
}

}  // namespace ilp
