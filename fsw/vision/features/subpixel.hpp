// Sub-pixel registration of a small patch: inverse compositional Lucas-Kanade with an affine warp, a gain and an offset
// (S. Baker, I. Matthews, "Lucas-Kanade 20 years on", IJCV 2004).
#pragma once

#include "fsw/vision/features/patch.hpp"

namespace ilp {

/// The patch around a point of image a, prepared once: steepest descent images and the factor of their normal
/// equations.
struct PatchTemplate {
  static constexpr int unknowns = 7;  ///< affine (xx, xy, yx, yy) and shift (x, y), each times the gain; gain

  std::int32_t side = 0;
  float variance_sum = 0;                                                ///< sum of the squared values, mean removed
  std::array<std::array<float, padded_patch_pixels>, unknowns> descent;  ///< means removed, which eliminates the offset
  float factor[unknowns][unknowns];
};

/// A point of image b and the linear map from the neighbourhood of its counterpart in a.
struct PatchWarp {
  float x = 0, y = 0;
  Linear2 linear;
  float ncc = 0;
};

/// False when the patch and its gradients leave the image, or its texture does not determine an affine warp.
[[nodiscard]] bool prepare_patch(SmoothView image_a, float x, float y, std::int32_t side, PatchTemplate& out);

/// Refines `warp` in place. False when it leaves the image, does not converge to a hundredth of a pixel, or ends on a
/// patch that is too clipped.
[[nodiscard]] bool register_patch(const PatchTemplate& a, SmoothView image_b, PatchWarp& warp);

}  // namespace ilp
