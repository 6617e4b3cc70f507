// Closes loops of a model with a small part of its tracks.
#pragma once

#include "sim/ground/model/growth.hpp"

namespace ilp::model {

/// Does the same as close_loops(), but adjusts only as many tracks as any two views need to keep 8 common tracks, or
/// all that they have. The other points follow their views. Closing loops only has to bring sightings within the bounds
/// of the adjustment that follows, and for this few points of each pair of views are enough.
void close_loops_by_few(const Scene& scene, double drift_px, Model& model, double tolerance);

}  // namespace ilp::model
