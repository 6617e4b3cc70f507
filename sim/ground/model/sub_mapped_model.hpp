// Makes the model of a long flight from sub-maps, which are adjusted one after the other and joined by their common
// keyframes.
#pragma once

#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"

namespace ilp::model {

/// Makes the model of the unit `seed` and of all views that sub-maps connect with it, with covariances. Sets `taken`
/// for its units. Returns false if the model has at most whole_model_views keyframes, so that it is to be adjusted as a
/// whole, or if no sub-maps can be made or joined; then only the scene may have got further sightings.
[[nodiscard]] bool grow_in_sub_maps(const intake::Flight& flight, const std::vector<Unit>& units, std::size_t seed,
                                    Scene& scene, std::vector<std::uint8_t>& taken, Model& model,
                                    const JoinProgress& progress);

/// Number of strips with keyframes in the model.
[[nodiscard]] std::size_t strips_in(const Scene& scene, const Model& model);

}  // namespace ilp::model
