// Divides the keyframes and tracks of a long flight into sub-maps, which are adjusted separately.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Models of at most this number of keyframes are adjusted as a whole.
inline constexpr std::size_t whole_model_views = 250;

/// For each view, not 0 if tracks and strips connect it with the view `with`.
[[nodiscard]] std::vector<std::uint8_t> connected_views(const Scene& scene, std::uint32_t with);

/// A sub-map before it is adjusted. A track belongs to at most one sub-map. A keyframe belongs to every sub-map of
/// which it sees enough tracks, so that sub-maps have keyframes in common.
struct SubMapPlan {
  std::vector<std::uint32_t> views;  ///< ascending
  std::vector<std::size_t> tracks;   ///< ascending
  /// Tracks of other sub-maps without which some views of this one could not be placed; ascending.
  std::vector<std::size_t> support;
};

/// Divides the views for which `wanted` is not 0. Keyframes are assigned in the order of their ids. A keyframe that
/// sees ground again joins the sub-map with most of its tracks. Others join the sub-map of the keyframe before in their
/// strip, until it has enough. Later keyframes change only sub-maps whose tracks they see.
[[nodiscard]] std::vector<SubMapPlan> plan_sub_maps(const Scene& scene, const std::vector<std::uint8_t>& wanted);

}  // namespace ilp::model
