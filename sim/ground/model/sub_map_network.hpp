// Sub-maps that stand in one model by the keyframes that they have in common.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/ground/model/sub_map.hpp"

namespace ilp::model {

/// Lets the model have the cameras of the sub-map `first`, and of all others that share cameras with it or with each
/// other, each where two or more cameras that stand already put it. `taken`: by sub-map, set for those that have found
/// a place. The model must have room for the views.
[[nodiscard]] std::vector<const SubMap*> place_sub_maps(const std::vector<SubMap>& maps, std::size_t first,
                                                        std::vector<std::uint8_t>& taken, Model& model);

/// model_from_map by the cameras of the map that stand in the model; none for fewer than two of them.
[[nodiscard]] std::optional<Similarity> model_from_sub_map(const SubMap& map, const Model& model);

/// Least squares over all cameras: each sub-map says how its cameras stand to each other, in a world and a unit of its
/// own. States the cameras' errors, as state_errors() does. `to_world` moves the model to where it shall stand, after
/// each step. False where some camera is not determined, or stands far from where a sub-map has it.
[[nodiscard]] bool adjust_network(const std::vector<const SubMap*>& maps, const std::function<void(Model&)>& to_world,
                                  Model& model);

}  // namespace ilp::model
