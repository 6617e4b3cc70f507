// Samples of the vehicle's own navigation: height, attitude, position and velocity with their standard deviations. Each
// quantity is optional: a standard deviation (sigma) of 0 means that it was not measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/time.hpp"

namespace ilp {

/// The local level frame has its origin in the camera and the axes east, north and up.
struct NavigationSample {
  TimeNs time_ns = 0;   ///< mission time of the measurement
  double height_m = 0;  ///< height of the camera above the ground vertically below it
  double height_sigma_m = 0;
  double q_cam_from_level[4] = {1, 0, 0, 0};  ///< unit quaternion w, x, y, z
  double tilt_sigma_rad = 0;                  ///< sigma of the attitude about each horizontal axis
  double heading_sigma_rad = 0;               ///< sigma about the vertical; 0: the attitude gives only the vertical
  double longitude_deg = 0, latitude_deg = 0;
  double elevation_m = 0;              ///< above the body's ellipsoid (fsw/shared/body_figure.hpp)
  double horizontal_sigma_m = 0;       ///< sigma of the position to the east and to the north
  double vertical_sigma_m = 0;         ///< sigma of the elevation
  double velocity_m_s[3] = {0, 0, 0};  ///< east, north, up
  double velocity_sigma_m_s = 0;
};

/// Groups of columns. A file has all columns of a group or none of them.
enum class NavigationGroup : std::uint8_t { time, height, attitude, heading, horizontal, vertical, velocity, count };

struct NavigationColumn {
  const char* name;  ///< ends in the unit
  NavigationGroup group;
  double* (*value)(NavigationSample&);  ///< null for the time
};

inline constexpr std::size_t navigation_column_count = 18;
/// The columns of a file with navigation. Packets have the values in the same order. The first one is the time.
[[nodiscard]] std::span<const NavigationColumn, navigation_column_count> navigation_columns();

/// Whether all values are finite and in range, no sigma is negative, and the quaternion has unit length.
[[nodiscard]] bool plausible(const NavigationSample& sample);

}  // namespace ilp
