// The size of the bodies flown, as their maps have it.
#pragma once

#include "cfg/choices.hpp"

namespace ilp {

/// Zeros without a body.
struct BodyRadii {
  double equatorial_m = 0, polar_m = 0;
};
[[nodiscard]] BodyRadii body_radii(Body body);

/// Metres to the east and to the north per degree of longitude and latitude, at a place above the body's figure: the
/// IAU's spheres (2015), and the WGS 84 ellipsoid. 0 without a body.
struct DegreeLengths {
  double east_m = 0, north_m = 0;
};
[[nodiscard]] DegreeLengths degree_lengths(Body body, double latitude_deg, double elevation_m);

/// Planetographic, the elevation above the body's figure.
struct BodyPlace {
  double longitude_deg = 0, latitude_deg = 0, elevation_m = 0;
};
/// Metres to the east, north and up from `origin`, the shorter way around the body. Valid near the origin, as is
/// place_at, which goes the other way.
void offset_from(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]);
[[nodiscard]] BodyPlace place_at(Body body, const BodyPlace& origin, const double (&offset_m)[3]);

}  // namespace ilp
