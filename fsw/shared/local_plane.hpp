// A plane about an origin on a body: the transverse Mercator projection with its centre and true scale at the origin.
// Over tens of kilometres it preserves shapes and lengths (on Mars a length 10 km from the origin is too long by 4e-6),
// which offset_from (body_figure.hpp) does not. Maps of orbiters lie on such a plane.
//
// Source: C. F. F. Karney, "Transverse Mercator with an accuracy of a few nanometers", J. Geodesy 85, 2011: Krueger's
// series, here to the third order of the flattening, exact to a millimetre within 1000 km.
#pragma once

#include "fsw/shared/body_figure.hpp"

namespace ilp {

/// Projects `place` to the plane about `origin`: east, north and up, m; up is the difference of the elevations. The
/// projection is valid within 60 degrees of the origin's meridian; farther places get large finite offsets without
/// meaning. Zeros for Body::none.
void plane_from_place(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]);
/// The inverse of plane_from_place.
[[nodiscard]] BodyPlace place_from_plane(Body body, const BodyPlace& origin, const double (&offset_m)[3]);
/// Angle at `place` from the north of its meridian to the plane's north, clockwise, rad. It is positive for a place
/// east of the origin on a northern latitude. 0 for Body::none.
[[nodiscard]] double plane_north(Body body, const BodyPlace& origin, const BodyPlace& place);

}  // namespace ilp
