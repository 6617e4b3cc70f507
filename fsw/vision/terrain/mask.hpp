// The part of an image that is worth sending: ground that no earlier pair of the strip has reconstructed at least as
// well (paper 4.2, fig. 4; decisions.md, 9).
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

/// What earlier pairs have reconstructed of the ground in the strip's current image: one bit per pixel, and how well
/// they saw it, by cells. Trivially copyable: this is all that a strip carries from pair to pair.
struct Coverage {
  std::int32_t width = 0, height = 0;
  SeenCells seen;
  std::array<std::uint64_t, (limits::max_image_pixels + 63) / 64> bits{};

  [[nodiscard]] bool at(std::size_t pixel) const { return (bits[pixel >> 6U] >> (pixel & 63U) & 1U) != 0; }
  [[nodiscard]] bool at(std::int32_t x, std::int32_t y) const { return at(index(x, y)); }
  void set(std::size_t pixel) { bits[pixel >> 6U] |= std::uint64_t{1} << (pixel & 63U); }
  /// Covers a pixel with ground of this quality, which is not 0. The pixel in the middle of a cell decides for the
  /// cell, so that borders between qualities do not move when they are carried on; without it the first one does.
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

/// The part of it that an image of its size uses.
[[nodiscard]] std::span<const std::byte> memory_of(const Coverage& coverage);

/// Covers nothing, as at the start of a strip. `image_too_large`.
Status clear_coverage(std::int32_t width, std::int32_t height, Coverage& coverage);

/// What is seen badly is not seen: takes away the depths whose sigma is above `largest_sigma` of their distance.
void drop_uncertain_depths(double largest_sigma, const DepthView& depth);

/// Sets 255 where the pair gave depth (sigma > 0) and the ground was not covered, or `now` is better than what covers
/// it (at_least_as_well with `finer_steps`); 0 elsewhere. Counts both. `invalid_argument`: sizes differ.
struct MaskCounts {
  std::uint32_t matched = 0;
  std::uint32_t newly_seen = 0;
};
Status newly_seen_mask(ImageView<const float> sigma, const Coverage& coverage, const SeenCells& now,
                       std::int32_t finer_steps, const ImageView<std::uint8_t>& mask, MaskCounts& counts);

struct CoverageWorkspace {
  /// Quality of the ground in image i+1, 0 where it is not covered: as hit, and with holes closed.
  std::array<std::uint8_t, limits::max_image_pixels> hit, closed;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
  std::array<float, static_cast<std::size_t>(limits::max_image_width)> inverse_depth;
  std::int32_t next_row;  ///< of image i
  float fallback;         ///< inverse depth of rows without any
};

/// How well the ground of a pair's first image is known after the pair: as `now` inside its mask, as its coverage says
/// elsewhere.
struct PairGround {
  ImageView<const float> inverse_depth, sigma;
  MaskView mask;
  const SeenCells& now;
};

/// From coverage of image i to that of image i+1. Every pixel of image i that is covered, or matched now, covers the
/// pixels of image i+1 that see its ground. A covered pixel without depth borrows the nearest depth of its row, because
/// ground that was reconstructed before needs no new match to stay covered. Where the images are turned against each
/// other, holes of up to two pixels remain between pixels; they are closed. `next_from_reference` maps camera
/// coordinates of image i to those of image i+1.
Status carry_coverage(const CameraModel& camera, const PairGround& ground, const RigidTransform& next_from_reference,
                      CoverageWorkspace& workspace, Coverage& coverage);

/// The same in slices: one call of begin_carrying, then of carry_coverage_slice with the same arguments while
/// there is more. The coverage changes in the last one.
Status begin_carrying(const CameraModel& camera, const PairGround& ground, CoverageWorkspace& workspace,
                      const Coverage& coverage);
Result<bool> carry_coverage_slice(const CameraModel& camera, const PairGround& ground,
                                  const RigidTransform& next_from_reference, CoverageWorkspace& workspace,
                                  Coverage& coverage);

/// Coverage over a plane, for an image without a pose, or after a pair without depth: a pixel is covered with the
/// quality `known(x, y)` of the reference's nearest pixel, unless that is 0. `reference_from_image` is the plane's
/// homography, px to px. Pixels that it maps outside the reference keep their coverage.
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
