// Capacities for large images of 2048 x 2048 px.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp::limits {

inline constexpr const char* profile = "large";

// Images
inline constexpr std::int32_t max_image_width = 2048;
inline constexpr std::int32_t max_image_height = 2048;
inline constexpr std::size_t max_corners = 2048;
inline constexpr std::int32_t max_disparities = 256;

// One window of bundle adjustment: 7 keyframes at 85 % overlap (decisions.md, 5), and one more as a reserve
inline constexpr std::size_t max_window_keyframes = 8;
inline constexpr std::size_t max_fixed_keyframes = 8;  ///< cameras before the window that still see its points
inline constexpr std::size_t max_bundle_points = 4096;

// Memory of the flight software and of its libraries
inline constexpr std::size_t max_static_bytes = std::size_t{1} << 30U;
inline constexpr std::size_t sqlite_arena_bytes = std::size_t{64} << 20U;
inline constexpr std::size_t openjpeg_arena_bytes = std::size_t{80} << 20U;
inline constexpr std::size_t ram_store_bytes = 2 * sqlite_arena_bytes;

}  // namespace ilp::limits
