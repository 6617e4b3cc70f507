// Points where the cameras stay as they are.
#pragma once

#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Moves each placed point, by two to six steps of Gauss and Newton with Cauchy's loss, to where its sightings meet
/// best. Points that stand by the depths about them stay.
void refine_points(const Scene& scene, double robust_px, Model& model);

}  // namespace ilp::model
