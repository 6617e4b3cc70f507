// Chooses pairs of keyframes, and matches their corners by normalised cross-correlation where a plane's homography
// predicts them.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/model/scene.hpp"

namespace ilp::model {

/// Two views of the same ground, a < b, with the homography of its plane from real (distorted) px of a to those of b,
/// row-major.
struct PairRelation {
  std::uint32_t a = 0, b = 0;
  double plane_b_from_a[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  float radius_px = 32;  ///< search radius about the predicted position of a corner
};

/// For each view, not 0 if it has no pose or its strip has fewer than 8. Only pairs with such a view are matched again:
/// downlinked images show new ground only, so that images of long strips show little ground in common.
[[nodiscard]] std::vector<std::uint8_t> weakly_connected_views(const Scene& scene);

/// The pairs of the flight's links whose keyframes have images and of which at least one is weakly connected.
[[nodiscard]] std::vector<PairRelation> relations_by_links(const intake::Flight& flight, const Scene& scene);

/// The pairs that verify_place recognises among all pairs with images of which at least one view is weakly connected.
/// Pairs in `known`, and posed keyframes of one strip, are left out.
[[nodiscard]] std::vector<PairRelation> relations_by_features(const Scene& scene,
                                                              const std::vector<PairRelation>& known);

/// Matches the corners of each pair in both directions, on all cores. A match of a corner becomes a sighting of its
/// track in the other view. A corner without a track starts one. The result does not depend on the number of cores.
void match_pairs(const std::vector<PairRelation>& relations, Scene& scene);

}  // namespace ilp::model
