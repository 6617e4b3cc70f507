#include "sim/tools/gps/gps_sample.hpp"

#include <cmath>
#include <numbers>

namespace ilp::gps {
namespace {

// gpsd states errors that hold with 95 % confidence: of a value, and of a place in a plane.
constexpr double sigmas_of_a_value = 1.96;
constexpr double sigmas_of_a_place = 2.4477;
constexpr std::int64_t days_from_1958_to_1970 = 4383;

bool known(double value) {
  return std::isfinite(value);
}
bool is_error(double value) {
  return known(value) && value > 0;
}

}  // namespace

bool sample_of(const gps_fix_t& fix, NavigationSample& sample, UtcNs& utc) {
  if (fix.mode < MODE_2D || !known(fix.latitude) || !known(fix.longitude) || !is_error(fix.eph)) return false;
  if (fix.time.tv_sec <= 0) return false;
  sample = {};
  utc = (fix.time.tv_sec + days_from_1958_to_1970 * seconds_per_day) * ns_per_s + fix.time.tv_nsec;
  sample.longitude_deg = fix.longitude;
  sample.latitude_deg = fix.latitude;
  sample.horizontal_sigma_m = fix.eph / sigmas_of_a_place;
  if (fix.mode >= MODE_3D && known(fix.altHAE) && is_error(fix.epv)) {
    sample.elevation_m = fix.altHAE;
    sample.vertical_sigma_m = fix.epv / sigmas_of_a_value;
  }
  if (known(fix.speed) && known(fix.track) && known(fix.climb) && is_error(fix.eps)) {
    const double track = fix.track * std::numbers::pi / 180;
    sample.velocity_m_s[0] = fix.speed * std::sin(track);
    sample.velocity_m_s[1] = fix.speed * std::cos(track);
    sample.velocity_m_s[2] = fix.climb;
    sample.velocity_sigma_m_s = std::max(fix.eps, is_error(fix.epc) ? fix.epc : 0) / sigmas_of_a_value;
  }
  return true;
}

}  // namespace ilp::gps
