// Capacities of an onboard computer: images of 640 x 480 px, 64 MiB of static memory.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp::limits {

inline constexpr const char* profile = "flight";

// Images
inline constexpr std::int32_t max_image_width = 640;
inline constexpr std::int32_t max_image_height = 480;
inline constexpr std::size_t max_corners = 2048;
inline constexpr std::int32_t max_disparities = 256;

// One window of bundle adjustment: 7 keyframes at 85 % overlap (decisions.md, 5), and one more as a reserve
inline constexpr std::size_t max_window_keyframes = 8;
inline constexpr std::size_t max_fixed_keyframes = 8;  ///< cameras before the window that still see its points
inline constexpr std::size_t max_bundle_points = 4096;

// Memory of the flight software and of its libraries
inline constexpr std::size_t max_static_bytes = std::size_t{64} << 20U;
inline constexpr std::size_t sqlite_arena_bytes = std::size_t{6} << 20U;  // 5.1 MiB used at worst in the default flight
inline constexpr std::size_t openjpeg_arena_bytes = std::size_t{9} << 19U;  // 4.2 MiB used at worst (13-bit noise)
// With a store in memory this region has the records; with a store on disk it is SQLite's memory.
inline constexpr std::size_t ram_store_bytes = std::size_t{45} << 18U;

}  // namespace ilp::limits
