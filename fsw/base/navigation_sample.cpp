#include "fsw/base/navigation_sample.hpp"

#include <array>
#include <cmath>

#include "fsw/base/geometry.hpp"

namespace ilp {
namespace {

constexpr double farthest_m = 1e8;
constexpr double fastest_m_s = 1e5;

using Sample = NavigationSample;
using Group = NavigationGroup;
constexpr std::array<NavigationColumn, navigation_column_count> columns = {{
    {"time_s", Group::time, nullptr},
    {"height_m", Group::height, [](Sample& s) { return &s.height_m; }},
    {"height_sigma_m", Group::height, [](Sample& s) { return &s.height_sigma_m; }},
    {"qw", Group::attitude, [](Sample& s) { return &s.q_cam_from_level[0]; }},
    {"qx", Group::attitude, [](Sample& s) { return &s.q_cam_from_level[1]; }},
    {"qy", Group::attitude, [](Sample& s) { return &s.q_cam_from_level[2]; }},
    {"qz", Group::attitude, [](Sample& s) { return &s.q_cam_from_level[3]; }},
    {"tilt_sigma_rad", Group::attitude, [](Sample& s) { return &s.tilt_sigma_rad; }},
    {"heading_sigma_rad", Group::heading, [](Sample& s) { return &s.heading_sigma_rad; }},
    {"longitude_deg", Group::horizontal, [](Sample& s) { return &s.longitude_deg; }},
    {"latitude_deg", Group::horizontal, [](Sample& s) { return &s.latitude_deg; }},
    {"horizontal_sigma_m", Group::horizontal, [](Sample& s) { return &s.horizontal_sigma_m; }},
    {"elevation_m", Group::vertical, [](Sample& s) { return &s.elevation_m; }},
    {"vertical_sigma_m", Group::vertical, [](Sample& s) { return &s.vertical_sigma_m; }},
    {"velocity_east_m_s", Group::velocity, [](Sample& s) { return &s.velocity_m_s[0]; }},
    {"velocity_north_m_s", Group::velocity, [](Sample& s) { return &s.velocity_m_s[1]; }},
    {"velocity_up_m_s", Group::velocity, [](Sample& s) { return &s.velocity_m_s[2]; }},
    {"velocity_sigma_m_s", Group::velocity, [](Sample& s) { return &s.velocity_sigma_m_s; }},
}};

bool is_sigma(double sigma, double most) {
  return sigma >= 0 && sigma <= most;
}

bool within(double value, double most) {
  return std::fabs(value) <= most;
}

}  // namespace

std::span<const NavigationColumn, navigation_column_count> navigation_columns() {
  return columns;
}

// Comparisons with NaN are false, so no value that is not a number passes.
bool plausible(const NavigationSample& s) {
  bool good = is_sigma(s.height_sigma_m, farthest_m) && is_sigma(s.tilt_sigma_rad, 4) &&
              is_sigma(s.heading_sigma_rad, 4) && is_sigma(s.horizontal_sigma_m, farthest_m) &&
              is_sigma(s.vertical_sigma_m, farthest_m) && is_sigma(s.velocity_sigma_m_s, fastest_m_s);
  if (s.height_sigma_m > 0) good = good && s.height_m > 0 && s.height_m <= farthest_m;
  if (s.tilt_sigma_rad > 0) good = good && is_unit_quaternion(s.q_cam_from_level);
  if (s.horizontal_sigma_m > 0) good = good && within(s.longitude_deg, 360) && within(s.latitude_deg, 90);
  if (s.vertical_sigma_m > 0) good = good && within(s.elevation_m, farthest_m);
  for (const double v : s.velocity_m_s) good = good && within(v, fastest_m_s);
  return good;
}

}  // namespace ilp
