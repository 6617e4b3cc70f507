#include "fsw/shared/body_figure.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
BodyRadii body_radii(Body body) {
  switch (body) {
    case Body::none:
    case Body::count:
      break;
    case Body::mars:
      return {3396190, 3396190};
    case Body::titan:
      return {2575000, 2575000};
    case Body::venus:
      return {6051800, 6051800};
    case Body::moon:
      return {1737400, 1737400};
    case Body::earth:
      return {6378137, 6356752.314245};
  }
  return {};
}

DegreeLengths degree_lengths(Body body, double latitude_deg, double elevation_m) {
  const BodyRadii figure = body_radii(body);
  if (!(figure.equatorial_m > 0)) return {};
  constexpr double rad_per_deg = pi / 180;
  const double sine = det_sin(latitude_deg * rad_per_deg), cosine = det_cos(latitude_deg * rad_per_deg);
  const double e2 = 1 - (figure.polar_m * figure.polar_m) / (figure.equatorial_m * figure.equatorial_m);
  const double w = std::sqrt(1 - e2 * sine * sine);
  const double prime_vertical = figure.equatorial_m / w;
  const double meridian = figure.equatorial_m * (1 - e2) / (w * w * w);
  return {(prime_vertical + elevation_m) * cosine * rad_per_deg, (meridian + elevation_m) * rad_per_deg};
}

void offset_from(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]) {
  const DegreeLengths degree = degree_lengths(body, origin.latitude_deg, origin.elevation_m);
  const double turn = place.longitude_deg - origin.longitude_deg;
  offset_m[0] = degree.east_m * (turn - 360 * std::floor(turn / 360 + 0.5));
  offset_m[1] = degree.north_m * (place.latitude_deg - origin.latitude_deg);
  offset_m[2] = place.elevation_m - origin.elevation_m;
}

BodyPlace place_at(Body body, const BodyPlace& origin, const double (&offset_m)[3]) {
  const DegreeLengths degree = degree_lengths(body, origin.latitude_deg, origin.elevation_m);
  return {origin.longitude_deg + offset_m[0] / degree.east_m, origin.latitude_deg + offset_m[1] / degree.north_m,
          origin.elevation_m + offset_m[2]};
}

}  // namespace ilp
