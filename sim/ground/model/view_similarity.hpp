// The similarity between two worlds by one keyframe that stands in one of them and sees points of the other.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/view_depths.hpp"

namespace ilp::model {

struct SeenPoint {
  Vec3 position = Vec3::Zero();
  Sighting seen;
};
using SeenPoints = std::vector<std::vector<SeenPoint>>;  ///< by view

/// A sighting fits a similarity within this distance.
inline constexpr double fits_px = 4;

/// Whether so many sightings that fit place a unit: 12, and a quarter of all.
inline constexpr std::size_t min_sightings = 12;
[[nodiscard]] constexpr bool enough(std::size_t fit, std::size_t all) {
  return fit >= min_sightings && 4 * fit >= all;
}

/// Points of one world in the views for which `wanted` holds. A track that has no point yet, but is seen by a view of
/// the world, stands where the depths there put it.
template <typename Wanted>
[[nodiscard]] SeenPoints seen_points(const Scene& scene, const World& world, const ViewDepths& depths, Wanted wanted);

struct Resected {
  RigidTransform camera_from_world;
  std::size_t inliers = 0;
};
/// None if 10 points do not agree. Matches on the edge of a body that turns fit a camera that has only turned, at the
/// place of another keyframe of the points' `world`. Where more than a tenth of all contradict such a pose, one on
/// these alone is taken if enough of all fit it and half of these, and none otherwise.
[[nodiscard]] std::optional<Resected> resect_view(const Scene& scene, std::uint32_t view,
                                                  const std::vector<SeenPoint>& seen, const World& world);

/// points_from_view: attitude and place of view `v` from its resection on `seen`, which are points of another `world`
/// than that in which it has `pose`; the scale from the depths of both worlds' points in its image, of points near each
/// other if there are eight. None if 10 points do not agree, or the depths do not tell.
[[nodiscard]] std::optional<Similarity> similarity_by_view(const Scene& scene, std::uint32_t v,
                                                           const std::vector<SeenPoint>& seen, const World& world,
                                                           const RigidTransform& pose, const ViewDepths& depths);

/// Where a track stands in a world: at its point, or where the depths of a view that sees it put it.
[[nodiscard]] std::optional<Vec3> position_in(const Scene& scene, const World& world, const ViewDepths& depths,
                                              std::size_t track);

template <typename Wanted>
SeenPoints seen_points(const Scene& scene, const World& world, const ViewDepths& depths, Wanted wanted) {
  SeenPoints seen(scene.views.size());
  for (std::size_t t = 0; t < scene.tracks.size(); ++t) {
    std::optional<Vec3> position;
    for (const Sighting& one : scene.tracks[t].seen) {
      if (!wanted(one.view)) continue;
      if (!position) position = position_in(scene, world, depths, t);
      if (!position) break;
      seen[one.view].push_back({*position, one});
    }
  }
  return seen;
}

}  // namespace ilp::model
