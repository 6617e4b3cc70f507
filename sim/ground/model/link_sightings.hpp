// Points of the ground that the flight has registered in two linked keyframes.
#pragma once

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Adds each LinkPoint as a sighting. A point of the flight within 3 px of it in one keyframe moves over to the other
/// keyframe by the homography's linear part there; where there is none, the pair begins a track of its own, and links
/// of the same place share it.
void add_link_sightings(const intake::Flight& flight, Scene& scene);

}  // namespace ilp::model
