#include "fsw/localisation/sun.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double rad_per_deg = pi / 180;
constexpr double days_per_century = 36525;
/// Terrestrial time less UTC since 2017. It was five seconds less in 2000, in which the Earth turns by 0.02 degrees.
constexpr double terrestrial_less_utc_days = 69.184 / 86400;
constexpr double obliquity_2000_rad = 23.43928 * rad_per_deg;

/// At 2000-01-01 12:00, and the change in a century; degrees, the ecliptic and equinox of 2000.
struct OrbitalElements {
  double axis_au, eccentricity, eccentricity_rate, inclination, inclination_rate, longitude, longitude_rate, perihelion,
      perihelion_rate, node, node_rate;
};
constexpr OrbitalElements venus = {0.72333566,     0.00677672,   -0.00004107, 3.39467605,  -0.00078890, 181.97909950,
                                   58517.81538729, 131.60246718, 0.00268329,  76.67984255, -0.27769418};
constexpr OrbitalElements earth = {1.00000261,
                                   0.01671123,
                                   -0.00004392,
                                   -0.00001531,
                                   -0.01294668,
                                   100.46457166,
                                   35999.37244981,
                                   102.93768193,
                                   0.32327364,
                                   0,
                                   0};
constexpr OrbitalElements mars = {1.52371034,     0.09339410,   0.00007882, 1.84969142,  -0.00813131, -4.55343205,
                                  19140.30268499, -23.94362959, 0.44441088, 49.55953891, -0.29257343};
constexpr OrbitalElements saturn = {9.53667594,    0.05386179,  -0.00050991, 2.48599187,   0.00193609, 49.95424423,
                                    1222.49362201, 92.59887831, -0.41897216, 113.66242448, -0.28867794};

/// Direction of the north pole and the angle of the prime meridian from the node of the body's equator on that of the
/// Earth, degrees.
struct Rotation {
  double right_ascension, declination, meridian;
};

struct Vector {
  double x, y, z;
};

/// Of any number of turns.
double rad_of(double degrees) {
  return rad_per_deg * (degrees - 360 * std::floor(degrees / 360));
}
double sin_deg(double degrees) {
  return det_sin(rad_of(degrees));
}
double cos_deg(double degrees) {
  return det_cos(rad_of(degrees));
}

/// Kepler's equation by Newton's method; eccentricities are below 0.1.
double eccentric_anomaly(double mean_anomaly, double eccentricity) {
  double anomaly = mean_anomaly + eccentricity * det_sin(mean_anomaly);
  for (int i = 0; i < 5; ++i) {
    const double rest = anomaly - eccentricity * det_sin(anomaly) - mean_anomaly;
    anomaly -= rest / (1 - eccentricity * det_cos(anomaly));
  }
  return anomaly;
}

/// From the sun to the planet, in the axes of the Earth's equator of 2000.
Vector planet_from_sun(const OrbitalElements& of, double centuries) {
  const double e = of.eccentricity + of.eccentricity_rate * centuries;
  const double inclination = of.inclination + of.inclination_rate * centuries;
  const double longitude = of.longitude + of.longitude_rate * centuries;
  const double perihelion = of.perihelion + of.perihelion_rate * centuries;
  const double node = of.node + of.node_rate * centuries;
  const double anomaly = eccentric_anomaly(rad_of(longitude - perihelion), e);
  const double x = of.axis_au * (det_cos(anomaly) - e);
  const double y = of.axis_au * std::sqrt(1 - e * e) * det_sin(anomaly);
  const double cos_w = cos_deg(perihelion - node), sin_w = sin_deg(perihelion - node);
  const double cos_n = cos_deg(node), sin_n = sin_deg(node);
  const double cos_i = cos_deg(inclination), sin_i = sin_deg(inclination);
  const double along = cos_w * x - sin_w * y, across = sin_w * x + cos_w * y;
  const Vector ecliptic = {cos_n * along - sin_n * cos_i * across, sin_n * along + cos_n * cos_i * across,
                           sin_i * across};
  const double cos_o = det_cos(obliquity_2000_rad), sin_o = det_sin(obliquity_2000_rad);
  return {ecliptic.x, cos_o * ecliptic.y - sin_o * ecliptic.z, sin_o * ecliptic.y + cos_o * ecliptic.z};
}

/// The largest of the Moon's physical librations; what is left out is below 0.1 degrees.
Rotation rotation_of_moon(double days, double centuries) {
  const double e1 = 125.045 - 0.0529921 * days, e2 = 250.089 - 0.1059842 * days;
  const double e3 = 260.008 + 13.0120009 * days, e4 = 176.625 + 13.3407154 * days;
  return {269.9949 + 0.0031 * centuries - 3.8787 * sin_deg(e1) - 0.1204 * sin_deg(e2) + 0.0700 * sin_deg(e3),
          66.5392 + 0.0130 * centuries + 1.5419 * cos_deg(e1) + 0.0239 * cos_deg(e2) - 0.0278 * cos_deg(e3),
          38.3213 + 13.17635815 * days + 3.5610 * sin_deg(e1) + 0.1208 * sin_deg(e2) - 0.0642 * sin_deg(e3) +
              0.0158 * sin_deg(e4)};
}

Rotation rotation_of(Body body, double days) {
  const double centuries = days / days_per_century;
  switch (body) {
    case Body::none:
    case Body::count:
      break;
    case Body::mars:
      return {317.68143 - 0.1061 * centuries, 52.88650 - 0.0609 * centuries, 176.630 + 350.89198226 * days};
    case Body::titan:
      return {39.4827, 83.4279, 186.5855 + 22.5769768 * days};
    case Body::venus:
      return {272.76, 67.16, 160.20 - 1.4813688 * days};
    case Body::moon:
      return rotation_of_moon(days, centuries);
    case Body::earth:
      return {-0.641 * centuries, 90 - 0.557 * centuries, 190.147 + 360.9856235 * days};
  }
  return {0, 90, 0};
}

const OrbitalElements& elements_of(Body body) {
  if (body == Body::venus) return venus;
  if (body == Body::mars) return mars;
  if (body == Body::titan) return saturn;
  return earth;
}

}  // namespace

SubsolarPoint subsolar_point(Body body, double days) {
  if (body == Body::none || body >= Body::count) return {};
  const double terrestrial = days + terrestrial_less_utc_days;
  const Vector planet = planet_from_sun(elements_of(body), terrestrial / days_per_century);
  const Vector sun = {-planet.x, -planet.y, -planet.z};
  const Rotation turn = rotation_of(body, terrestrial);
  // About z to the node of the equators, about x to the body's equator, about its pole to the prime meridian.
  const double cos_a = cos_deg(turn.right_ascension + 90), sin_a = sin_deg(turn.right_ascension + 90);
  const double x = cos_a * sun.x + sin_a * sun.y, across = -sin_a * sun.x + cos_a * sun.y;
  const double cos_d = cos_deg(90 - turn.declination), sin_d = sin_deg(90 - turn.declination);
  const double y = cos_d * across + sin_d * sun.z, z = -sin_d * across + cos_d * sun.z;
  const double longitude = det_atan2(y, x) - rad_of(turn.meridian);
  return {longitude - 2 * pi * std::floor(longitude / (2 * pi) + 0.5), det_atan2(z, std::sqrt(x * x + y * y))};
}

SunPlace sun_over(const SubsolarPoint& sun, double longitude_rad, double latitude_rad) {
  const double hour = sun.longitude_rad - longitude_rad;
  const double cos_s = det_cos(sun.latitude_rad), sin_s = det_sin(sun.latitude_rad);
  const double cos_l = det_cos(latitude_rad), sin_l = det_sin(latitude_rad);
  const double east = cos_s * det_sin(hour);
  const double north = cos_l * sin_s - sin_l * cos_s * det_cos(hour);
  const double up = sin_l * sin_s + cos_l * cos_s * det_cos(hour);
  const double azimuth = det_atan2(east, north);
  return {azimuth < 0 ? azimuth + 2 * pi : azimuth, det_atan2(up, std::sqrt(east * east + north * north))};
}

double days_since_2000(double epoch_s, TimeNs time_ns) {
  // 1958-01-01 00:00 to 2000-01-01 12:00.
  constexpr double first_days = 15340.5;
  return epoch_s / 86400 - first_days + static_cast<double>(time_ns) / 86400e9;
}

}  // namespace ilp
