// Finds the part of an image to send: ground that no earlier pair of the strip has reconstructed at least as well
// (paper 4.2, fig. 4; decisions.md, 9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/result.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp {

/// The ground in the strip's current image that earlier pairs have reconstructed: one bit per pixel, and the quality
/// with which they saw it, by cells. Trivially copyable. A strip carries nothing else of it from pair to pair.
struct Coverage {
  std::int32_t width = 0, height = 0;
  SeenCells seen;
  std::array<std::uint64_t, (limits::max_image_pixels + 63) / 64> bits{};

  [[nodiscard]] bool at(std::size_t pixel) const { return (bits[pixel >> 6U] >> (pixel & 63U) & 1U) != 0; }
  [[nodiscard]] bool at(std::int32_t x, std::int32_t y) const { return at(index(x, y)); }
  void set(std::size_t pixel) { bits[pixel >> 6U] |= std::uint64_t{1} << (pixel & 63U); }
  /// Marks a pixel as covered by ground of `quality`, which must not be 0. The quality of a cell is that of the pixel
  /// in its middle, so that borders between qualities do not move when they are carried to the next image. Until that
  /// pixel is covered, it is the quality of the first covered pixel.
  void cover(std::int32_t x, std::int32_t y, std::uint8_t quality) {
    set(index(x, y));
    std::uint8_t& cell = seen.of(x, y);
    constexpr std::int32_t middle = seen_cell_px / 2;
    if (cell == 0 || (x % seen_cell_px == middle && y % seen_cell_px == middle)) cell = quality;
  }

 private:
  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  }
};

/// Returns the bytes of `coverage` that an image of its size uses.
[[nodiscard]] std::span<const std::byte> memory_of(const Coverage& coverage);

/// Sets the size and covers nothing, as at the start of a strip. Returns `image_too_large` if the size is out of range.
Status clear_coverage(std::int32_t width, std::int32_t height, Coverage& coverage);

/// Removes uncertain depths: sets inverse depth and sigma to 0 where the relative sigma, sigma / inverse depth, exceeds
/// `largest_sigma`.
void drop_uncertain_depths(double largest_sigma, const DepthView& depth);

/// Computes the mask of newly seen ground and counts its pixels. A pixel is 255 if the pair gave it depth (sigma > 0)
/// and its ground either was not covered, or is seen better `now` than before (at_least_as_well with `finer_steps`);
/// otherwise it is 0. Returns `invalid_argument` if sizes differ.
struct MaskCounts {
  std::uint32_t matched = 0;     ///< pixels to which the pair gave depth
  std::uint32_t newly_seen = 0;  ///< pixels that are set in the mask
};
Status newly_seen_mask(ImageView<const float> sigma, const Coverage& coverage, const SeenCells& now,
                       std::int32_t finer_steps, const ImageView<std::uint8_t>& mask, MaskCounts& counts);

struct CoverageWorkspace {
  /// Quality of the ground in image i+1, 0 where it is not covered: before and after holes are closed.
  std::array<std::uint8_t, limits::max_image_pixels> hit, closed;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
  std::array<float, static_cast<std::size_t>(limits::max_image_width)> inverse_depth;
  std::int32_t next_row;  ///< next row of image i to carry
  float fallback;         ///< inverse depth for rows without any depth
};

/// Depth and quality of the ground in the first image of a pair, after the pair. The quality is `now` inside `mask`,
/// and that of the coverage outside.
struct PairGround {
  ImageView<const float> inverse_depth, sigma;
  MaskView mask;
  const SeenCells& now;
};

/// Carries the coverage of image i to image i+1. Every pixel of image i that is covered, or that the pair matched,
/// covers the pixels of image i+1 that see its ground. A covered pixel without depth takes the nearest depth of its
/// row, because reconstructed ground stays covered without a new match. If the images are rotated against each other,
/// holes of up to two pixels remain between the projected pixels; they are closed. `next_from_reference` maps camera
/// coordinates of image i to those of image i+1. Returns `invalid_argument` if sizes differ.
Status carry_coverage(const CameraModel& camera, const PairGround& ground, const RigidTransform& next_from_reference,
                      CoverageWorkspace& workspace, Coverage& coverage);

/// Does the same in slices: call begin_carrying once, then carry_coverage_slice with the same arguments until it
/// returns false. The last slice writes the coverage.
Status begin_carrying(const CameraModel& camera, const PairGround& ground, CoverageWorkspace& workspace,
                      const Coverage& coverage);
Result<bool> carry_coverage_slice(const CameraModel& camera, const PairGround& ground,
                                  const RigidTransform& next_from_reference, CoverageWorkspace& workspace,
                                  Coverage& coverage);

/// Updates coverage over a plane, for an image without a pose or after a pair without depth. A pixel is covered with
/// the quality `known(x, y)` of the nearest pixel of the reference image, unless that is 0. `reference_from_image` is
/// the homography of the plane, px to px. Pixels that it maps outside the reference image keep their coverage.
template <typename Known>
void cover_over_plane(const Mat3& reference_from_image, Known known, Coverage& coverage) {
  for (std::int32_t y = 0; y < coverage.height; ++y) {
    for (std::int32_t x = 0; x < coverage.width; ++x) {
      const Vec3 p = reference_from_image * Vec3(x, y, 1);
      const double u = p.x() / p.z() + 0.5;
      const double v = p.y() / p.z() + 0.5;
      if (!(p.z() > 0 && u >= 0 && v >= 0 && u < coverage.width && v < coverage.height)) continue;
      const std::uint8_t quality = known(static_cast<std::int32_t>(u), static_cast<std::int32_t>(v));
      if (quality != 0) coverage.cover(x, y, quality);
    }
  }
}

}  // namespace ilp
