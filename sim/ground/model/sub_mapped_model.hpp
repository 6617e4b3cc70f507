// The model of a long flight: sub-maps that are adjusted one after the other, and stand in one model by the keyframes
// that they have in common.
#pragma once

#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"

namespace ilp::model {

/// Makes the model of the unit `seed` and of all that sub-maps connect with it, with the errors of its cameras, and
/// marks its units as taken. False, and nothing is changed but the scene's sightings, where so few keyframes may belong
/// to it that it is adjusted as a whole, or no sub-maps can be made.
[[nodiscard]] bool grow_in_sub_maps(const intake::Flight& flight, const std::vector<Unit>& units, std::size_t seed,
                                    Scene& scene, std::vector<std::uint8_t>& taken, Model& model,
                                    const JoinProgress& progress);

/// Of how many strips the model has keyframes.
[[nodiscard]] std::size_t strips_in(const Scene& scene, const Model& model);

}  // namespace ilp::model
