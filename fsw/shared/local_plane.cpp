#include "fsw/shared/local_plane.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "fsw/base/math.hpp"

namespace ilp {
namespace {

constexpr double rad_per_deg = pi / 180;
constexpr int orders = 3;

double sinh_of(double x) {
  return 0.5 * (det_exp(x) - det_exp(-x));
}
double cosh_of(double x) {
  return 0.5 * (det_exp(x) + det_exp(-x));
}
/// Finite at 1 too: sines are 1 at the poles, and a quarter of a turn from the origin.
double atanh_of(double x) {
  constexpr double most = 1 - std::numeric_limits<double>::epsilon() / 2;
  const double inside = std::clamp(x, -most, most);
  return 0.5 * det_log((1 + inside) / (1 - inside));
}

/// Series by the third flattening n: to the plane (alpha), back (beta), and of the latitude by the conformal one
/// (delta); A is the radius of a circle as long as a meridian.
struct Series {
  double radius, eccentricity;
  double alpha[orders], beta[orders], delta[orders];
};
Series series_of(Body body) {
  const BodyRadii radii = body_radii(body);
  const double n = (radii.equatorial_m - radii.polar_m) / (radii.equatorial_m + radii.polar_m);
  const double n2 = n * n, n3 = n2 * n;
  return {radii.equatorial_m / (1 + n) * (1 + n2 / 4 + n2 * n2 / 64),
          2 * std::sqrt(n) / (1 + n),
          {n / 2 - 2 * n2 / 3 + 5 * n3 / 16, 13 * n2 / 48 - 3 * n3 / 5, 61 * n3 / 240},
          {n / 2 - 2 * n2 / 3 + 37 * n3 / 96, n2 / 48 + n3 / 15, 17 * n3 / 480},
          {2 * n - 2 * n2 / 3 - 2 * n3, 7 * n2 / 3 - 8 * n3 / 5, 56 * n3 / 15}};
}

/// Northing and easting in radii, from the equator and the meridian.
struct Plane {
  double xi, eta;
};

/// Tangent of the conformal latitude.
double conformal_tangent(const Series& series, double latitude_rad) {
  const double sine = det_sin(latitude_rad);
  return sinh_of(atanh_of(sine) - series.eccentricity * atanh_of(series.eccentricity * sine));
}

Plane to_plane(const Series& series, double latitude_rad, double turn_rad) {
  const double tangent = conformal_tangent(series, latitude_rad);
  const double xi = det_atan2(tangent, det_cos(turn_rad));
  const double eta = atanh_of(det_sin(turn_rad) / std::sqrt(1 + tangent * tangent));
  Plane out{xi, eta};
  for (int j = 1; j <= orders; ++j) {
    out.xi += series.alpha[j - 1] * det_sin(2 * j * xi) * cosh_of(2 * j * eta);
    out.eta += series.alpha[j - 1] * det_cos(2 * j * xi) * sinh_of(2 * j * eta);
  }
  return out;
}

/// The shorter way around the body.
double turn_between(double from_deg, double to_deg) {
  const double turn = to_deg - from_deg;
  return rad_per_deg * (turn - 360 * std::floor(turn / 360 + 0.5));
}

}  // namespace

void plane_from_place(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]) {
  const Series series = series_of(body);
  offset_m[0] = offset_m[1] = offset_m[2] = 0;
  if (!(series.radius > 0)) return;
  const Plane centre = to_plane(series, rad_per_deg * origin.latitude_deg, 0);
  const Plane at =
      to_plane(series, rad_per_deg * place.latitude_deg, turn_between(origin.longitude_deg, place.longitude_deg));
  offset_m[0] = series.radius * at.eta;
  offset_m[1] = series.radius * (at.xi - centre.xi);
  offset_m[2] = place.elevation_m - origin.elevation_m;
}

BodyPlace place_from_plane(Body body, const BodyPlace& origin, const double (&offset_m)[3]) {
  const Series series = series_of(body);
  if (!(series.radius > 0)) return {};
  const Plane centre = to_plane(series, rad_per_deg * origin.latitude_deg, 0);
  const Plane at{centre.xi + offset_m[1] / series.radius, offset_m[0] / series.radius};
  double xi = at.xi, eta = at.eta;
  for (int j = 1; j <= orders; ++j) {
    xi -= series.beta[j - 1] * det_sin(2 * j * at.xi) * cosh_of(2 * j * at.eta);
    eta -= series.beta[j - 1] * det_cos(2 * j * at.xi) * sinh_of(2 * j * at.eta);
  }
  const double conformal = det_asin(det_sin(xi) / cosh_of(eta));
  double latitude = conformal;
  for (int j = 1; j <= orders; ++j) latitude += series.delta[j - 1] * det_sin(2 * j * conformal);
  const double longitude = origin.longitude_deg + det_atan2(sinh_of(eta), det_cos(xi)) / rad_per_deg;
  return {longitude - 360 * std::floor(longitude / 360 + 0.5), latitude / rad_per_deg,
          origin.elevation_m + offset_m[2]};
}

double plane_north(Body body, const BodyPlace& origin, const BodyPlace& place) {
  if (!(body_radii(body).equatorial_m > 0)) return 0;
  const double turn = turn_between(origin.longitude_deg, place.longitude_deg);
  return det_atan2(det_sin(turn) * det_sin(rad_per_deg * place.latitude_deg), det_cos(turn));
}

}  // namespace ilp
