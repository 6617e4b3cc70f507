// A map of disparities with their errors, and how each was found.
#pragma once

#include <cstdint>

#include "fsw/base/image_view.hpp"

namespace ilp {

/// How a pixel has got its disparity. Each kind is a bit.
enum class DisparityKind : std::uint8_t {
  none = 0,       ///< it has no disparity
  measured = 1,   ///< by its own window
  resolved = 2,   ///< chosen between the surfaces beside an edge, with an error that is final (edge_surfaces.hpp)
  supported = 4,  ///< not matched: that of the ground around it, which the images confirm (gap_support.hpp)
};
/// Whether a match, not its surroundings, gave the pixel its disparity.
[[nodiscard]] constexpr bool is_matched(DisparityKind kind) {
  constexpr int matches = static_cast<int>(DisparityKind::measured) | static_cast<int>(DisparityKind::resolved);
  return (static_cast<int>(kind) & matches) != 0;
}

/// Disparities x_left - x_right on the left image's grid. Their errors are one sigma, px; 0 for pixels without a
/// disparity.
struct DisparityView {
  ImageView<float> disparity_px;
  ImageView<float> sigma_px;
  ImageView<DisparityKind> kind{};  ///< StereoMatcher has this plane in its workspace
};

}  // namespace ilp
