// Disparity map of a rectified pair: disparities, their errors, and how each one was found.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// How a pixel got its disparity. Each kind is one bit.
enum class DisparityKind : std::uint8_t {
  none = 0,       ///< the pixel has no disparity
  measured = 1,   ///< matched by the correlation of the pixel's own window
  resolved = 2,   ///< chosen between the surfaces beside an edge; later steps keep its error (edge_surfaces.hpp)
  supported = 4,  ///< not matched: taken from the ground around it, and confirmed by the images (gap_support.hpp)
};
/// Returns true if the disparity comes from a match of the pixel itself, not from its surroundings.
[[nodiscard]] constexpr bool is_matched(DisparityKind kind) {
  constexpr int matches = static_cast<int>(DisparityKind::measured) | static_cast<int>(DisparityKind::resolved);
  return (static_cast<int>(kind) & matches) != 0;
}

/// Disparities x_left - x_right on the pixel grid of the left image. `sigma_px` is their one-sigma error, 0 for pixels
/// without a disparity.
struct DisparityView {
  ImageView<float> disparity_px;
  ImageView<float> sigma_px;
  ImageView<DisparityKind> kind{};  ///< StereoMatcher keeps this plane in its workspace
};

}  // namespace ilp
