// A rectified pair reduced to a quarter of its resolution, for the coarse search.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

struct StereoPairView {
  GrayView left, right;
  MaskView left_valid, right_valid;
};

inline constexpr std::int32_t coarse_step = 4;

/// The reduced pair. Each pixel is the mean of coarse_step x coarse_step pixels, and valid if all of these are. Rows
/// and columns at the end that do not fill a coarse pixel are left out.
struct CoarsePair {
  MutableGrayView left, right;
  ImageView<std::uint8_t> left_valid, right_valid;

  [[nodiscard]] StereoPairView view() const { return {left, right, left_valid, right_valid}; }
};

/// Bytes of the coarse pair of a pair of `width` x `height` px.
[[nodiscard]] constexpr std::size_t coarse_pair_bytes(std::int32_t width, std::int32_t height) {
  return 4 * static_cast<std::size_t>(width / coarse_step) * static_cast<std::size_t>(height / coarse_step);
}
/// Places the coarse pair of a pair of `width` x `height` px in `bytes`, which holds coarse_pair_bytes(width, height).
[[nodiscard]] CoarsePair make_coarse_pair(std::uint8_t* bytes, std::int32_t width, std::int32_t height);

/// Computes row `y` of the coarse pair.
void reduce_row(const StereoPairView& pair, std::int32_t y, const CoarsePair& coarse);

}  // namespace ilp
