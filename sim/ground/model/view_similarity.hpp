// Estimates the similarity between two worlds from one keyframe that has a pose in one and sees points of the other.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/view_depths.hpp"

namespace ilp::model {

/// A point of a world with its sighting in a view.
struct SeenPoint {
  Vec3 position = Vec3::Zero();
  Sighting seen;
};
using SeenPoints = std::vector<std::vector<SeenPoint>>;  ///< for each view, the points that it sees

/// Largest reprojection error of an inlier.
inline constexpr double fits_px = 4;

/// Whether `fit` inliers of `all` sightings suffice to place a unit: at least 12, and at least a quarter of all.
inline constexpr std::size_t min_sightings = 12;
[[nodiscard]] constexpr bool enough(std::size_t fit, std::size_t all) {
  return fit >= min_sightings && 4 * fit >= all;
}

/// The points of a world that the views with `wanted(view)` see. A track without a point in the world gets its position
/// from the depths in a view of the world that sees it (position_in).
template <typename Wanted>
[[nodiscard]] SeenPoints seen_points(const Scene& scene, const World& world, const ViewDepths& depths, Wanted wanted);

struct Resected {
  RigidTransform camera_from_world;
  std::size_t inliers = 0;
};
/// Estimates a view's pose from the points that it sees; none if fewer than 10 agree. A pose at the position of another
/// keyframe of `world` is suspect, because matches on the limb of a rotating body fit a camera that has only rotated.
/// If more than a tenth of the points contradict a suspect pose, a second pose is estimated from these alone. It is
/// taken if it is not suspect, enough of all points fit it (enough()), and at least half of these; otherwise there is
/// none.
[[nodiscard]] std::optional<Resected> resect_view(const Scene& scene, std::uint32_t view,
                                                  const std::vector<SeenPoint>& seen, const World& world);

/// The similarity from the world in which view `v` has the pose `pose` to the world `world` of the points `seen`.
/// Rotation and translation come from the resection of the view on these points. The scale is the median ratio of the
/// depths in both worlds: at points near each other in the image (ViewDepths::near) if there are eight, else at any
/// (ViewDepths::any). `depths`: of the view's world. None if the resection fails or there are fewer than eight ratios.
[[nodiscard]] std::optional<Similarity> similarity_by_view(const Scene& scene, std::uint32_t v,
                                                           const std::vector<SeenPoint>& seen, const World& world,
                                                           const RigidTransform& pose, const ViewDepths& depths);

/// Position of a track in a world: its point, or else the position from the interpolated depth in a view that sees it.
/// None if there is neither.
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
