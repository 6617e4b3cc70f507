// Predicts from poses and points of a model which pairs of keyframes show the same ground.
#pragma once

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/pair_matching.hpp"

namespace ilp::model {

/// Returns pairs of views with images to be matched. At least one of the two is weakly connected
/// (weakly_connected_views), and the newer one sees at least a seventh of the earlier one's points. Keyframes near each
/// other in one strip are left out, because the flight's own points relate them. A view has at most eight pairs with
/// earlier views, those with most common ground, so that the number of pairs is linear in the number of keyframes.
[[nodiscard]] std::vector<PairRelation> relations_by_model(const Scene& scene, const Model& model);

}  // namespace ilp::model
