// Sub-pixel registration of a small patch: inverse compositional Lucas-Kanade with an affine warp, a gain and an offset
// (S. Baker, I. Matthews, "Lucas-Kanade 20 years on", IJCV 2004).
#pragma once

#include "fsw/vision/features/patch.hpp"

namespace ilp {

/// The patch around a point of image a, prepared once for several registrations: steepest descent images and the
/// Cholesky factor of their normal equations.
struct PatchTemplate {
  /// Affine (xx, xy, yx, yy) and shift (x, y), each multiplied by the gain; then the gain.
  static constexpr int unknowns = 7;

  std::int32_t side = 0;
  float variance_sum = 0;  ///< sum of the squared grey values after their mean is removed
  /// Steepest descent images without their means, which eliminates the offset.
  std::array<std::array<float, padded_patch_pixels>, unknowns> descent;
  float factor[unknowns][unknowns];
};

/// Position of a point in image b, and the linear part of the warp from image a to image b around it.
struct PatchWarp {
  float x = 0, y = 0;
  Linear2 linear;
  float ncc = 0;  ///< normalised cross-correlation at the registered position, -1 to 1
};

/// Prepares the patch of `side` x `side` px around (x, y). Returns false if the patch or its gradients leave the image,
/// or if its texture does not determine an affine warp.
[[nodiscard]] bool prepare_patch(SmoothView image_a, float x, float y, std::int32_t side, PatchTemplate& out);

/// Refines `warp` in place, from its initial value, and sets its ncc. Returns false if the patch leaves the image, if
/// the iterations do not converge to 0.01 px, or if the final patch is too clipped.
[[nodiscard]] bool register_patch(const PatchTemplate& a, SmoothView image_b, PatchWarp& warp);

}  // namespace ilp
