// Strips and keyframes that are not in the model yet find their place in it by the points that they see.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Keyframes that move together: those of a strip that the flight has posed, or one keyframe without a pose.
struct Unit {
  std::int64_t strip_id = 0;
  bool rigid = false;  ///< two or more keyframes in their strip's world
  std::vector<std::uint32_t> views;
};
[[nodiscard]] std::vector<Unit> units_of(const Scene& scene);

/// By unit, the number of tracks that it and the model see.
[[nodiscard]] std::vector<std::size_t> common_tracks(const Scene& scene, const Model& model,
                                                     const std::vector<Unit>& units);

/// Places the unit if at least 12 sightings between the two, and a quarter of them, fit within 4 px. One keyframe
/// without a pose is resected. A strip gets a similarity: a keyframe of one of the two is resected on the points of the
/// other, and the depths in its image give the scale; the keyframe whose similarity fits most sightings decides.
/// `seen_by`: of the scene.
[[nodiscard]] bool place(const Scene& scene, const TracksByView& seen_by, const Unit& unit, Model& model);

/// By view of the model, the tracks that a view shares with it. `seen_by`: of the scene.
[[nodiscard]] std::vector<std::size_t> shared_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                                     const Model& model);

/// The rung of a view that shares 12 tracks or more with each of two views of the model: where all points are shared
/// with the same view, nothing measures the distance from it. None for other views.
[[nodiscard]] std::optional<int> rung_by_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                                const Model& model);

/// The strip's views by this similarity.
void place_by(const Scene& scene, const Unit& unit, const Similarity& model_from_strip, Model& model);

}  // namespace ilp::model
