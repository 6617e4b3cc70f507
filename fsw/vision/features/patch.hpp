// Square patches, resampled under an affine warp, and their normalised cross correlation.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/image_view.hpp"

namespace ilp {

/// An image smoothed by [1 2 1]/4 in x and y, in sixteenths of a grey level (exact). Interpolating this image adds the
/// same small blur at every sub-pixel position, so that sub-pixel registration has no bias.
using SmoothView = ImageView<const std::uint16_t>;
inline constexpr float smooth_units_per_grey = 16;

/// Smooths `image`. `out` has the same size; border pixels are repeated outwards.
void smooth(GrayView image, ImageView<std::uint16_t> out);

/// Linear part of a mapping: (x, y) -> (xx x + xy y, yx x + yy y).
struct Linear2 {
  float xx = 1, xy = 0, yx = 0, yy = 1;
};

inline constexpr std::size_t max_patch_pixels =
    static_cast<std::size_t>(limits::max_patch_side) * static_cast<std::size_t>(limits::max_patch_side);
inline constexpr std::size_t patch_lanes = 8;
/// Pixels of a square patch, rounded up to whole vectors of patch_lanes.
[[nodiscard]] constexpr std::size_t padded_count(std::int32_t side) {
  const std::size_t n = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  return (n + patch_lanes - 1) / patch_lanes * patch_lanes;
}
/// Capacity of a patch. Elements after the last pixel of a patch are zero.
inline constexpr std::size_t padded_patch_pixels = padded_count(limits::max_patch_side);

/// Samples grey values at (x, y) + warp * (u, v) for u, v = -(side-1)/2 .. (side-1)/2, row by row. The values are those
/// of `image` with eight more fractional bits. Returns false if a sample would lie outside the image, or if `side` is
/// above max_sampled_side.
inline constexpr std::int32_t max_sampled_side = 64;
[[nodiscard]] bool sample_patch(SmoothView image, float x, float y, const Linear2& warp, std::int32_t side,
                                std::int32_t* out);

/// Returns true if more than a twentieth of the values of sample_patch are black or white together with all their
/// neighbours. The edges of such clipped areas depend on the exposure, not on the ground.
inline constexpr std::int32_t max_clipped_divisor = 20;
[[nodiscard]] bool too_clipped(const std::int32_t* values, std::int32_t count);

/// A patch with mean 0 and sum of squares 2^28, so that a correlation is an integer dot product.
using NormalizedPatch = std::array<std::int16_t, padded_patch_pixels>;
inline constexpr float normalized_patch_square = 268435456.0F;

/// Samples and normalises a patch. Returns false if the patch leaves the image, is too clipped, or has a standard
/// deviation below `min_stddev` grey levels.
[[nodiscard]] bool extract_patch(SmoothView image, float x, float y, const Linear2& warp, std::int32_t side,
                                 float min_stddev, NormalizedPatch& patch);

/// Returns the correlation of two patches: normalized_patch_square is a correlation of 1.
[[nodiscard]] std::int32_t correlate(const NormalizedPatch& p, const NormalizedPatch& q, std::int32_t side);

}  // namespace ilp
