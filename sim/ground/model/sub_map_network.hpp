// Joins sub-maps to one model by the keyframes that they have in common.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "sim/ground/model/sub_map.hpp"

namespace ilp::model {

/// Adds the cameras of sub-map `first` to the model, then those of other sub-maps, one after the other. Each is placed
/// by the similarity that two or more cameras determine which are in the model already. Returns the placed sub-maps.
/// `taken`: set to 1 for each placed sub-map. `model.views` must have the size of the scene's views.
[[nodiscard]] std::vector<const SubMap*> place_sub_maps(const std::vector<SubMap>& maps, std::size_t first,
                                                        std::vector<std::uint8_t>& taken, Model& model);

/// The similarity model_from_map that best aligns the map's cameras with those of the model; none for fewer than two
/// common cameras.
[[nodiscard]] std::optional<Similarity> model_from_sub_map(const SubMap& map, const Model& model);

/// Adjusts all cameras of the model by least squares. Each sub-map contributes the relative poses of its cameras, in a
/// world and a unit of its own. Sets the covariances of the views as state_errors() does. `to_world` is called after
/// each step, and moves the model to its world. Returns false if some camera is not determined, the steps do not
/// converge, or a camera is far from its position in a sub-map.
[[nodiscard]] bool adjust_network(const std::vector<const SubMap*>& maps, const std::function<void(Model&)>& to_world,
                                  Model& model);

}  // namespace ilp::model
