// What it promises to match a keyframe with another one, before anything is matched: how much of its ground both see,
// and how exactly the parallax between them gives its distance.
#pragma once

#include <cstdint>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/terrain/mask.hpp"

namespace ilp {

struct PairUtilityParams {
  double largest_sigma = 0.02;   ///< relative sigma above which a distance counts as not seen
  std::int32_t finer_steps = 5;  ///< of at_least_as_well
};

struct PairUtility {
  double common = 0;        ///< share of the first image whose ground the second image shows too
  double median_sigma = 0;  ///< median relative sigma of the distance over this share; 0 without common ground
  /// Mean over the image of what its ground gains: halvings of the sigma below the largest one, with a supplement where
  /// the ground is new. Ground that is known at least as well, and ground that only the first image shows, gain
  /// nothing.
  double utility = 0;
};

/// The ground counts as a plane across the optical axis at `distance`. A point at relative sigma 1 would move by the
/// parallax p = f |(t_x - x t_z, t_y - y t_z)| / z in the second image, with t the translation of `second_from_first`
/// and (x, y, z) the point there; its relative sigma is that of a disparity, 0.1 px, over p. A pair of which less
/// than 0.3 of the image is common is worth nothing.
[[nodiscard]] PairUtility pair_utility(const CameraModel& camera, const RigidTransform& second_from_first,
                                       double distance, const Coverage& coverage, const PairUtilityParams& params);

}  // namespace ilp
