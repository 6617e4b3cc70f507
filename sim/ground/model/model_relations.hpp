// Pairs of keyframes that show the same ground by the poses and points of a model.
#pragma once

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/pair_matching.hpp"

namespace ilp::model {

/// Pairs of which one is weakly connected and that share a seventh of the earlier one's points. Keyframes of a strip
/// that are near each other in it are left out, because the flight's own points relate them. Each keyframe takes at
/// most eight earlier ones, those with most common ground, so that the work is linear in the number of keyframes.
[[nodiscard]] std::vector<PairRelation> relations_by_model(const Scene& scene, const Model& model);

}  // namespace ilp::model
