// The ellipsoids of the bodies, and metres for differences of longitude and latitude. Ellipsoids are the IAU's spheres
// (2015), and WGS 84 for the Earth.
#pragma once

#include "cfg/choices.hpp"

namespace ilp {

/// Radii of a body's ellipsoid; zeros for Body::none.
struct BodyRadii {
  double equatorial_m = 0, polar_m = 0;
};
[[nodiscard]] BodyRadii body_radii(Body body);

/// Metres to the east per degree of longitude and to the north per degree of latitude. The elevation is above the
/// ellipsoid. Zeros for Body::none.
struct DegreeLengths {
  double east_m = 0, north_m = 0;
};
[[nodiscard]] DegreeLengths degree_lengths(Body body, double latitude_deg, double elevation_m);

/// A planetographic position; the elevation is above the ellipsoid.
struct BodyPlace {
  double longitude_deg = 0, latitude_deg = 0, elevation_m = 0;
};
/// Offset of `place` from `origin`: metres to the east, north and up, the shorter way around the body. The degree
/// lengths are those at the origin, so that the offset is valid near the origin only.
void offset_from(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]);
/// The inverse of offset_from. `body` must not be none.
[[nodiscard]] BodyPlace place_at(Body body, const BodyPlace& origin, const double (&offset_m)[3]);

}  // namespace ilp
