// The size of the bodies flown, as their maps have it.
#pragma once

#include "cfg/choices.hpp"

namespace ilp {

/// Metres to the east and to the north per degree of longitude and latitude, at a place above the body's figure: the
/// IAU's spheres (2015), and the WGS 84 ellipsoid. 0 without a body.
struct DegreeLengths {
  double east_m = 0, north_m = 0;
};
[[nodiscard]] DegreeLengths degree_lengths(Body body, double latitude_deg, double elevation_m);

}  // namespace ilp
