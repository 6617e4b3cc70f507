#include "fsw/base/navigation_sample.hpp"

#include <cmath>

namespace ilp {
namespace {

constexpr double farthest_m = 1e8;
constexpr double fastest_m_s = 1e5;

bool is_sigma(double sigma, double most) {
  return sigma >= 0 && sigma <= most;
}

bool within(double value, double most) {
  return std::fabs(value) <= most;
}

}  // namespace

// Comparisons with NaN are false, so no value that is not a number passes.
bool plausible(const NavigationSample& s) {
  double norm2 = 0;
  for (const double q : s.q_cam_from_level) norm2 += q * q;
  bool good = is_sigma(s.height_sigma_m, farthest_m) && is_sigma(s.tilt_sigma_rad, 4) &&
              is_sigma(s.heading_sigma_rad, 4) && is_sigma(s.horizontal_sigma_m, farthest_m) &&
              is_sigma(s.vertical_sigma_m, farthest_m) && is_sigma(s.velocity_sigma_m_s, fastest_m_s);
  if (s.height_sigma_m > 0) good = good && s.height_m > 0 && s.height_m <= farthest_m;
  if (s.tilt_sigma_rad > 0) good = good && within(norm2 - 1, 1e-3);
  if (s.horizontal_sigma_m > 0) good = good && within(s.longitude_deg, 360) && within(s.latitude_deg, 90);
  if (s.vertical_sigma_m > 0) good = good && within(s.elevation_m, farthest_m);
  for (const double v : s.velocity_m_s) good = good && within(v, fastest_m_s);
  return good;
}

}  // namespace ilp
