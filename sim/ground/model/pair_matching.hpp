// Matches of two keyframes: which pairs are worth it, and their corners by normalised cross correlation where a plane
// predicts them.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Views a < b of the same ground, with the homography of its plane, row-major, real px of a to real px of b.
struct PairRelation {
  std::uint32_t a = 0, b = 0;
  double plane_b_from_a[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  float radius_px = 32;  ///< in which a corner is sought about its prediction
};

/// By view: whether it has no pose, or its strip has few. Images hold new ground only, so that those of long strips
/// that the flight has linked say little of what they have in common; of weakly connected ones they often do.
[[nodiscard]] std::vector<std::uint8_t> weakly_connected_views(const Scene& scene);

/// The flight's links, where one of the keyframes is weakly connected.
[[nodiscard]] std::vector<PairRelation> relations_by_links(const intake::Flight& flight, const Scene& scene);

/// Pairs that verify_place recognises, of those that have no relation yet and of which one keyframe is weakly
/// connected.
[[nodiscard]] std::vector<PairRelation> relations_by_features(const Scene& scene,
                                                              const std::vector<PairRelation>& known);

/// Matches the corners of each pair, in any order on all cores; each match becomes a sighting of the track of corner a
/// in view b. A track without a sighting so far begins with corner a.
void match_pairs(const std::vector<PairRelation>& relations, Scene& scene);

}  // namespace ilp::model
