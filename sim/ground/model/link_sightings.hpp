// Points of the ground that the flight has registered in two linked keyframes.
#pragma once

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Adds each LinkPoint as a sighting. A track, of the flight or of another link, within 3 px of it in one keyframe
/// moves over to the other keyframe by the homography's linear part there; where there is none, the pair begins a
/// track. The new sightings are corners of their views.
void add_link_sightings(const intake::Flight& flight, Scene& scene);

}  // namespace ilp::model
