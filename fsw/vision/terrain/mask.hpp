// The part of an image that is worth sending: ground that no earlier pair of the strip has reconstructed (paper 4.2,
// fig. 4; decisions.md, 9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"

namespace ilp {

/// One bit per pixel of the strip's current image: set if an earlier pair has reconstructed its ground. Trivially
/// copyable: this is all that a strip carries from pair to pair.
struct Coverage {
  std::int32_t width = 0, height = 0;
  std::array<std::uint64_t, (limits::max_image_pixels + 63) / 64> bits{};

  [[nodiscard]] bool at(std::size_t pixel) const { return (bits[pixel >> 6U] >> (pixel & 63U) & 1U) != 0; }
  void set(std::size_t pixel) { bits[pixel >> 6U] |= std::uint64_t{1} << (pixel & 63U); }
};

/// The bits that an image of its size uses, and no others.
[[nodiscard]] std::span<const std::byte> memory_of(const Coverage& coverage);

/// Covers nothing, as at the start of a strip. `image_too_large`.
Status clear_coverage(std::int32_t width, std::int32_t height, Coverage& coverage);

/// Sets 255 where the pair (i, i+1) gave depth (sigma > 0) and image i was not covered, 0 elsewhere, and counts both.
/// `invalid_argument`: sizes differ.
struct MaskCounts {
  std::uint32_t matched = 0;
  std::uint32_t newly_seen = 0;
};
Status newly_seen_mask(ImageView<const float> sigma, const Coverage& coverage, const ImageView<std::uint8_t>& mask,
                       MaskCounts& counts);

struct CoverageWorkspace {
  /// Coverage of image i+1, one byte a pixel: as hit, and with holes closed.
  std::array<std::uint8_t, limits::max_image_pixels> hit, closed;
  std::array<double, static_cast<std::size_t>(limits::max_image_width)> ray_x, ray_y;
  std::array<float, static_cast<std::size_t>(limits::max_image_width)> inverse_depth;
};

/// From coverage of image i to that of image i+1. Every pixel of image i that is covered, or matched now, covers the
/// pixels of image i+1 that see its ground. A covered pixel without depth borrows the nearest depth of its row, because
/// ground that was reconstructed before needs no new match to stay covered. Where the images are turned against each
/// other, holes of up to two pixels remain between pixels; they are closed. `next_from_reference` maps camera
/// coordinates of image i to those of image i+1.
Status carry_coverage(const CameraModel& camera, ImageView<const float> inverse_depth, ImageView<const float> sigma,
                      const RigidTransform& next_from_reference, CoverageWorkspace& workspace, Coverage& coverage);

/// Coverage over a plane, for an image without a pose, or after a pair without depth: its pixels are covered if
/// `covered(pixel)` of the reference's nearest pixel is true. `reference_from_image` is the plane's homography, px to
/// px. Pixels that it maps outside the reference keep their coverage.
template <typename Covered>
void cover_over_plane(const Mat3& reference_from_image, Covered covered, Coverage& coverage) {
  std::size_t pixel = 0;
  for (std::int32_t y = 0; y < coverage.height; ++y) {
    for (std::int32_t x = 0; x < coverage.width; ++x, ++pixel) {
      const Vec3 p = reference_from_image * Vec3(x, y, 1);
      const double u = p.x() / p.z() + 0.5;
      const double v = p.y() / p.z() + 0.5;
      if (!(p.z() > 0 && u >= 0 && v >= 0 && u < coverage.width && v < coverage.height)) continue;
      const auto reference =
          static_cast<std::size_t>(static_cast<std::int32_t>(v)) * static_cast<std::size_t>(coverage.width) +
          static_cast<std::size_t>(static_cast<std::int32_t>(u));
      if (covered(reference)) coverage.set(pixel);
    }
  }
}

}  // namespace ilp
