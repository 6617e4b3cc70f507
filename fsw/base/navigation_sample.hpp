// The vehicle's own measurements of where it is, as time-stamped samples. Each quantity is optional: its sigma is 0
// where it was not measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/time.hpp"

namespace ilp {

/// The local level frame has the axes east, north and up at the place of the camera.
struct NavigationSample {
  TimeNs time_ns = 0;   ///< of the measurement, since the mission epoch
  double height_m = 0;  ///< of the camera above the ground straight below it
  double height_sigma_m = 0;
  double q_cam_from_level[4] = {1, 0, 0, 0};  ///< unit quaternion w, x, y, z
  double tilt_sigma_rad = 0;                  ///< of the attitude about each horizontal axis
  double heading_sigma_rad = 0;               ///< about the vertical axis; 0: the attitude says only what is up
  double longitude_deg = 0, latitude_deg = 0;
  double elevation_m = 0;  ///< above the body's figure
  double horizontal_sigma_m = 0;
  double vertical_sigma_m = 0;  ///< 0: the elevation was not measured
  double velocity_m_s[3] = {0, 0, 0};
  double velocity_sigma_m_s = 0;
};

/// Columns of one group are given together, or not at all.
enum class NavigationGroup : std::uint8_t { time, height, attitude, heading, horizontal, vertical, velocity, count };

struct NavigationColumn {
  const char* name;  ///< with its unit
  NavigationGroup group;
  double* (*value)(NavigationSample&);  ///< null for the time
};

inline constexpr std::size_t navigation_column_count = 18;
/// The columns of a file, in the order of the values in a packet. The time is the first one.
[[nodiscard]] std::span<const NavigationColumn, navigation_column_count> navigation_columns();

/// Values in range, a unit quaternion, sigmas that are finite and not negative.
[[nodiscard]] bool plausible(const NavigationSample& sample);

}  // namespace ilp
