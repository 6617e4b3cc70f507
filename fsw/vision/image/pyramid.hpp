// Image pyramid (paper 3.1, "subsampled images"): every level halves the one before by averaging 2x2 pixels.
//
// Pixel x of level k covers pixels 2^k x to 2^k (x + 1) - 1 of the image, so its centre is at (x + 0.5) 2^k - 0.5 in
// the image. An odd last row or column is left out of the next level.
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Holds the levels of a pyramid. Level 0 is a view of the caller's image, which must outlive the pyramid; the other
/// levels are stored in the object.
class Pyramid {
 public:
  /// Halves `image` until its longer side is at most `coarsest_side_px` or limits::max_pyramid_levels is reached.
  /// Returns `image_too_large` if the image exceeds the limits, `invalid_argument` if it is empty or `coarsest_side_px`
  /// is below 1.
  Status build(GrayView image, std::int32_t coarsest_side_px);

  [[nodiscard]] int levels() const { return levels_; }
  [[nodiscard]] GrayView level(int k) const { return views_[static_cast<std::size_t>(k)]; }

 private:
  // 1/4 + 1/16 + ... < 1/3 of the image.
  std::array<std::uint8_t, limits::max_image_pixels / 3> pixels_{};
  std::array<GrayView, limits::max_pyramid_levels> views_{};
  int levels_ = 0;
};

/// Averages 2x2 pixels, rounded to nearest. `half` has half the size of `image`, rounded down.
void halve(GrayView image, MutableGrayView half);

}  // namespace ilp
