#include "fsw/shared/body_figure.hpp"

#include <cmath>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

struct Figure {
  double equatorial_m, polar_m;
};

Figure figure_of(Body body) {
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
  return {0, 0};
}

}  // namespace

DegreeLengths degree_lengths(Body body, double latitude_deg, double elevation_m) {
  const Figure figure = figure_of(body);
  if (!(figure.equatorial_m > 0)) return {};
  constexpr double rad_per_deg = pi / 180;
  const double sine = det_sin(latitude_deg * rad_per_deg), cosine = det_cos(latitude_deg * rad_per_deg);
  const double e2 = 1 - (figure.polar_m * figure.polar_m) / (figure.equatorial_m * figure.equatorial_m);
  const double w = std::sqrt(1 - e2 * sine * sine);
  const double prime_vertical = figure.equatorial_m / w;
  const double meridian = figure.equatorial_m * (1 - e2) / (w * w * w);
  return {(prime_vertical + elevation_m) * cosine * rad_per_deg, (meridian + elevation_m) * rad_per_deg};
}

}  // namespace ilp
