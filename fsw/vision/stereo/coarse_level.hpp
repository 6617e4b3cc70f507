// A rectified pair at half resolution.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

struct StereoPairView {
  GrayView left, right;
  MaskView left_valid, right_valid;
};

/// Pixel (x, y) is the mean of (2x, 2y) to (2x + 1, 2y + 1), valid where all four are. Odd last rows and columns are
/// left out.
struct CoarsePair {
  MutableGrayView left, right;
  ImageView<std::uint8_t> left_valid, right_valid;

  [[nodiscard]] StereoPairView view() const { return {left, right, left_valid, right_valid}; }
};

/// Bytes that a pair of this full size takes.
[[nodiscard]] constexpr std::size_t coarse_pair_bytes(std::int32_t width, std::int32_t height) {
  return 4 * static_cast<std::size_t>(width / 2) * static_cast<std::size_t>(height / 2);
}
/// A pair of that size in `bytes`, which holds coarse_pair_bytes.
[[nodiscard]] CoarsePair make_coarse_pair(std::uint8_t* bytes, std::int32_t width, std::int32_t height);

/// Row `y` at half resolution.
void halve_row(const StereoPairView& pair, std::int32_t y, const CoarsePair& coarse);

}  // namespace ilp
