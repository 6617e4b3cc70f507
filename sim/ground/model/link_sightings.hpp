// Adds the ground points of the flight's links to a scene: points that it has registered in two keyframes.
#pragma once

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Adds the sightings of each LinkPoint. If a track has a corner within 3 px of the point in one of the two keyframes,
/// the track gets a sighting in the other keyframe, displaced by the linear part of the link's homography. If there is
/// no such track in either keyframe, the point starts a track. New sightings become corners of their views.
void add_link_sightings(const intake::Flight& flight, Scene& scene);

}  // namespace ilp::model
