// Reduces an image by an integer factor.
#pragma once

#include "fsw/base/image_view.hpp"

namespace ilp {

/// Each pixel of `to` is the mean of a square of `factor` x `factor` pixels. The sides of `to` are those of the image
/// divided by the factor, rounded down.
inline void mean_of_squares(GrayView image, std::int32_t factor, MutableGrayView to) {
  const auto area = static_cast<std::uint32_t>(factor * factor);
  for (std::int32_t y = 0; y < to.height; ++y) {
    for (std::int32_t x = 0; x < to.width; ++x) {
      std::uint32_t sum = area / 2;
      for (std::int32_t k = 0; k < factor * factor; ++k)
        sum += image.at(x * factor + k % factor, y * factor + k / factor);
      to.at(x, y) = static_cast<std::uint8_t>(sum / area);
    }
  }
}

}  // namespace ilp
