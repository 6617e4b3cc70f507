// A rectified pair at a quarter of the resolution.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

struct StereoPairView {
  GrayView left, right;
  MaskView left_valid, right_valid;
};

inline constexpr std::int32_t coarse_step = 4;

/// A pixel is the mean of coarse_step x coarse_step pixels, valid where all of them are. Rows and columns at the end
/// that do not fill a coarse pixel are left out.
struct CoarsePair {
  MutableGrayView left, right;
  ImageView<std::uint8_t> left_valid, right_valid;

  [[nodiscard]] StereoPairView view() const { return {left, right, left_valid, right_valid}; }
};

/// Bytes of a pair of this full size.
[[nodiscard]] constexpr std::size_t coarse_pair_bytes(std::int32_t width, std::int32_t height) {
  return 4 * static_cast<std::size_t>(width / coarse_step) * static_cast<std::size_t>(height / coarse_step);
}
/// A pair of that size in `bytes`, which holds coarse_pair_bytes.
[[nodiscard]] CoarsePair make_coarse_pair(std::uint8_t* bytes, std::int32_t width, std::int32_t height);

/// Row `y` of the coarse pair.
void reduce_row(const StereoPairView& pair, std::int32_t y, const CoarsePair& coarse);

}  // namespace ilp
