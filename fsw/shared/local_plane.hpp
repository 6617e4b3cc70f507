// A plane about a place of a body: the transverse Mercator projection with its centre and true scale there. Over tens
// of kilometres it keeps shapes and lengths (10 km from its middle a metre is 1 + 4e-6 long on Mars), which longitude
// and latitude times their lengths do not. Maps of orbiters lie on such a plane.
//
// Source: C. F. F. Karney, "Transverse Mercator with an accuracy of a few nanometers", J. Geodesy 85, 2011: Krueger's
// series, here to the third order of the flattening, exact to a millimetre within 1000 km.
#pragma once

#include "fsw/shared/body_figure.hpp"

namespace ilp {

/// East, north and up on the plane about `origin`, m; up is the difference of elevations. Places within 60 degrees of
/// the origin's meridian; farther ones lie somewhere far away, at finite offsets. Zeros without a body.
void plane_from_place(Body body, const BodyPlace& origin, const BodyPlace& place, double (&offset_m)[3]);
/// The inverse.
[[nodiscard]] BodyPlace place_from_plane(Body body, const BodyPlace& origin, const double (&offset_m)[3]);
/// The plane's north at a place, clockwise from the north of its meridian, rad: where the place lies east of the origin
/// on a northern latitude, the meridian leans to the west of the plane's north.
[[nodiscard]] double plane_north(Body body, const BodyPlace& origin, const BodyPlace& place);

}  // namespace ilp
