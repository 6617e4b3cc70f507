#include "sim/host/thumbnail.hpp"

#include <limits>

namespace ilp::host {

std::uint8_t mean_grey(const Raster<std::uint8_t>& image, std::int32_t x0, std::int32_t y0, std::int32_t factor) {
  std::uint32_t sum = 0, count = 0;
  for (std::int32_t y = y0; y < std::min(y0 + factor, image.height); ++y) {
    for (std::int32_t x = x0; x < std::min(x0 + factor, image.width); ++x, ++count) sum += image.at(x, y);
  }
  return static_cast<std::uint8_t>((sum + count / 2) / std::max(count, 1U));
}

float mean_depth(const Raster<float>& inverse, std::int32_t x0, std::int32_t y0, std::int32_t factor) {
  double sum = 0;
  int count = 0;
  for (std::int32_t y = y0; y < std::min(y0 + factor, inverse.height); ++y) {
    for (std::int32_t x = x0; x < std::min(x0 + factor, inverse.width); ++x) {
      if (!(inverse.at(x, y) > 0)) continue;
      sum += inverse.at(x, y);
      ++count;
    }
  }
  return count == 0 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(count / sum);
}

}  // namespace ilp::host
