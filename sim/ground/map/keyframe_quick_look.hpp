// A summary of a keyframe's rasters: small pictures and a few numbers. It stays in memory; the rasters do not.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/ground/map/merge.hpp"

namespace ilp::map {

/// Bounds in the strip's world, strip units.
struct MapBounds {
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
};

struct KeyframeQuickLook {
  std::uint64_t digest = 0;           ///< keyframe_digest of the keyframe
  std::array<std::string, 2> faults;  ///< why a product cannot be decoded, by ProductKind; empty: decoded, or missing
  std::uint64_t depth_pixels = 0;     ///< number of pixels with a depth
  double median_depth = 0;            ///< camera z, strip units; 0: no depth
  double ground_step = 0;  ///< median distance of neighbouring pixels on the ground, strip units; 0: no surface
  MapBounds bounds;        ///< bounds of the surface without outliers; valid if ground_step > 0
  /// PNG files, about quick_look_width_px wide; empty if the raster is missing.
  std::vector<std::uint8_t> image, mask, depth;
  double nearest = 0, farthest = 0;  ///< depths at the ends of the colour scale of `depth`, strip units
};

/// Width of the pictures: the more keyframes a flight has, the smaller, so that the page with all pictures loads.
[[nodiscard]] std::int32_t quick_look_width_px(std::size_t keyframes);

[[nodiscard]] KeyframeQuickLook quick_look_at(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                              std::int32_t width_px, PixelRays& rays);

/// Digest of everything that the keyframe's rasters, surface and quick-look depend on.
[[nodiscard]] std::uint64_t keyframe_digest(const intake::Keyframe& keyframe);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const KeyframeQuickLook& quick_look);
/// Reads back what bytes_of wrote; none if the bytes are damaged.
[[nodiscard]] std::optional<KeyframeQuickLook> quick_look_from(std::span<const std::uint8_t> bytes);

}  // namespace ilp::map
