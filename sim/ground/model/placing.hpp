// Places strips and keyframes in a model by the points that they share with it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/model/model.hpp"

namespace ilp::model {

/// Keyframes that are placed together: those of a strip that the flight has posed, or one keyframe without a pose.
struct Unit {
  std::int64_t strip_id = 0;
  bool rigid = false;  ///< two or more keyframes in their strip's world
  std::vector<std::uint32_t> views;
};
[[nodiscard]] std::vector<Unit> units_of(const Scene& scene);

/// For each unit, the number of tracks that both it and the model see.
[[nodiscard]] std::vector<std::size_t> common_tracks(const Scene& scene, const Model& model,
                                                     const std::vector<Unit>& units);

/// Places a unit in the model if at least 12 sightings between the two, and at least a quarter of them, fit within 4
/// px; else returns false. A single keyframe is resected. A strip is placed by a similarity: each keyframe of strip and
/// model is resected on the points of the other, with the scale from the depths in its image, and the similarity that
/// fits most sightings is taken. `seen_by`: tracks_by_view of the scene.
[[nodiscard]] bool place(const Scene& scene, const TracksByView& seen_by, const Unit& unit, Model& model);

/// For each view of the scene, the number of tracks that it shares with view `v`; 0 if it is not in the model.
/// `seen_by`: tracks_by_view of the scene.
[[nodiscard]] std::vector<std::size_t> shared_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                                     const Model& model);

/// The rung (ModelView::rung) of view `v` if it shares at least 12 tracks with each of two or more views of the model:
/// the second lowest rung of these views. Else none. If it shares all points with one view, the points do not measure
/// its distance from that view.
[[nodiscard]] std::optional<int> rung_by_points(const Scene& scene, const TracksByView& seen_by, std::uint32_t v,
                                                const Model& model);

/// Places the views of a strip, and the flight's points of it, by a similarity.
void place_by(const Scene& scene, const Unit& unit, const Similarity& model_from_strip, Model& model);

}  // namespace ilp::model
