// Loops are closed by few of the tracks.
#pragma once

#include "sim/ground/model/growth.hpp"

namespace ilp::model {

/// As close_loops(), but only those tracks are adjusted without which two views would have fewer than 8 in common, or
/// all that they have. The other points move with their views and stand then where these see them. To close loops is to
/// bring sightings within the bounds of the adjustment that follows, and many points of one pair of views tell no more
/// about that than few.
void close_loops_by_few(const Scene& scene, double drift_px, Model& model, double tolerance);

}  // namespace ilp::model
