// Which keyframes and tracks of a long flight are adjusted together.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Models of no more keyframes are adjusted as a whole.
inline constexpr std::size_t whole_model_views = 250;

/// By view, whether tracks and strips connect it with the view `with`.
[[nodiscard]] std::vector<std::uint8_t> connected_views(const Scene& scene, std::uint32_t with);

/// A sub-map before it is adjusted. Every track belongs to one sub-map at most, and keyframes to all that they see
/// enough tracks of: these are what sub-maps have in common.
struct SubMapPlan {
  std::vector<std::uint32_t> views;  ///< ascending
  std::vector<std::size_t> tracks;   ///< ascending
  /// Tracks of other sub-maps without which some views would have no place in this one; ascending.
  std::vector<std::size_t> support;
};

/// Divides the views that are `wanted`. Keyframes come in the order of their numbers: one that sees ground again joins
/// the sub-map that has most of its tracks, others follow the one before, until there are enough. What comes later
/// changes only sub-maps whose tracks it sees.
[[nodiscard]] std::vector<SubMapPlan> plan_sub_maps(const Scene& scene, const std::vector<std::uint8_t>& wanted);

}  // namespace ilp::model
