// A summary of a keyframe's rasters that is kept after they have left memory.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/ground/map/merge.hpp"

namespace ilp::map {

/// Bounds in the strip's world.
struct MapBounds {
  double x_low = 0, x_high = 0, y_low = 0, y_high = 0;
};

struct KeyframeQuickLook {
  std::uint64_t digest = 0;           ///< keyframe_digest of what was looked at
  std::array<std::string, 2> faults;  ///< of its products, by ProductKind; empty: decodes, or did not come
  std::uint64_t depth_pixels = 0;
  double median_depth = 0;  ///< z, strip units; 0: none
  double ground_step = 0;   ///< median distance of neighbouring pixels on the ground, strip units
  MapBounds bounds;         ///< of its surface, without a few wild points; where ground_step > 0
  /// PNG, some quick_look_width_px wide; empty where there is none.
  std::vector<std::uint8_t> image, mask, depth;
  double nearest = 0, farthest = 0;  ///< of the colours of `depth`
};

/// Width of the pictures of a flight with this many keyframes: the page with all of them keeps a readable size.
[[nodiscard]] std::int32_t quick_look_width_px(std::size_t keyframes);

[[nodiscard]] KeyframeQuickLook quick_look_at(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters,
                                              std::int32_t width_px, PixelRays& rays);

/// Digest of everything that the keyframe's rasters, surface and quick-look depend on.
[[nodiscard]] std::uint64_t keyframe_digest(const intake::Keyframe& keyframe);

[[nodiscard]] std::vector<std::uint8_t> bytes_of(const KeyframeQuickLook& quick_look);
/// None when the bytes are not what bytes_of gave.
[[nodiscard]] std::optional<KeyframeQuickLook> quick_look_from(std::span<const std::uint8_t> bytes);

}  // namespace ilp::map
