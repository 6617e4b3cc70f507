#include "fsw/vision/image/pyramid.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/base/vector_width.hpp"

namespace ilp {

namespace {

void halve_rows(GrayView image, MutableGrayView half) {
  const std::ptrdiff_t width = half.width;
  for (std::int32_t y = 0; y < half.height; ++y) {
    const std::uint8_t* const upper = image.row(2 * y);
    const std::uint8_t* const lower = image.row(2 * y + 1);
    std::uint8_t* const __restrict out = half.row(y);
    for (std::ptrdiff_t x = 0; x < width; ++x) {
      const int sum = upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1];
      out[x] = static_cast<std::uint8_t>((sum + 2) >> 2);
    }
  }
}

}  // namespace

void halve(GrayView image, MutableGrayView half) {
  with_widest_vectors([&] { halve_rows(image, half); });
}

Status Pyramid::build(GrayView image, std::int32_t coarsest_side_px) {
  levels_ = 0;
  if (image.empty()) return out_of_range(Argument::image_size, image.width);
  if (coarsest_side_px < 1) return out_of_range(Argument::coarsest_side, coarsest_side_px);
  if (image.area() > limits::max_image_pixels) return {StatusCode::image_too_large, image.width, image.height};
  views_[0] = image;
  levels_ = 1;
  std::uint8_t* next = pixels_.data();
  while (levels_ < limits::max_pyramid_levels) {
    const GrayView fine = level(levels_ - 1);
    if (std::max(fine.width, fine.height) <= coarsest_side_px || std::min(fine.width, fine.height) < 2) break;
    const MutableGrayView coarse(next, fine.width / 2, fine.height / 2);
    halve(fine, coarse);
    next += coarse.area();
    views_[static_cast<std::size_t>(levels_++)] = coarse;
  }
  return {};
}

}  // namespace ilp
