// Capacities of the guest: images of 640 x 480 px as the flight has, bundle adjustment of more cameras and fewer points.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp::limits {

inline constexpr const char* profile = "guest";

// Images
inline constexpr std::int32_t max_image_width = 640;
inline constexpr std::int32_t max_image_height = 480;
inline constexpr std::size_t max_corners = 1500;
inline constexpr std::int32_t max_disparities = 192;

// One window of bundle adjustment (decisions.md, 5: 7 keyframes at 85 % overlap, one more for slack)
inline constexpr std::size_t max_window_keyframes = 12;
inline constexpr std::size_t max_fixed_keyframes = 4;  ///< cameras before the window that its points still see
inline constexpr std::size_t max_bundle_points = 3000;

// Memory of the flight and of its libraries
inline constexpr std::size_t max_static_bytes = std::size_t{256} << 20U;
inline constexpr std::size_t sqlite_arena_bytes = std::size_t{16} << 20U;
inline constexpr std::size_t openjpeg_arena_bytes = std::size_t{20} << 20U;  // 13.8 MiB used at worst
inline constexpr std::size_t ram_store_bytes = 2 * sqlite_arena_bytes;

}  // namespace ilp::limits
