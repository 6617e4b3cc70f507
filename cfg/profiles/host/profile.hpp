// Capacities of a desktop computer: images of 1024 x 1024 px.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp::limits {

inline constexpr const char* profile = "host";

// Images
inline constexpr std::int32_t max_image_width = 1024;
inline constexpr std::int32_t max_image_height = 1024;
inline constexpr std::size_t max_corners = 2048;
inline constexpr std::int32_t max_disparities = 256;

// One window of bundle adjustment: 7 keyframes at 85 % overlap (decisions.md, 5), and one more as a reserve
inline constexpr std::size_t max_window_keyframes = 8;
inline constexpr std::size_t max_fixed_keyframes = 8;  ///< cameras before the window that still see its points
inline constexpr std::size_t max_bundle_points = 4096;

// Memory of the flight software and of its libraries
inline constexpr std::size_t max_static_bytes = std::size_t{256} << 20U;
inline constexpr std::size_t sqlite_arena_bytes = std::size_t{16} << 20U;
inline constexpr std::size_t openjpeg_arena_bytes = std::size_t{20} << 20U;  // at most 13.8 MiB are used
inline constexpr std::size_t ram_store_bytes = 2 * sqlite_arena_bytes;

}  // namespace ilp::limits
