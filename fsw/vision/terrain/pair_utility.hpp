// Predicts the benefit of matching a keyframe with another one, before anything is matched: how much of its ground both
// see, and how accurate the distances from their parallax would be.
#pragma once

#include <cstdint>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/terrain/mask.hpp"

namespace ilp {

struct PairUtilityParams {
  double largest_sigma = 0.02;   ///< a distance with a larger relative sigma counts as not seen
  std::int32_t finer_steps = 5;  ///< argument of at_least_as_well
};

struct PairUtility {
  double common = 0;        ///< fraction of the first image whose ground the second image shows, too
  double median_sigma = 0;  ///< median relative sigma of the distance over this part; 0 without common ground
  /// Mean gain over the image. The gain of a sample is the number of halvings of its relative sigma below the largest
  /// one, plus a supplement if its ground is new. Ground that is known at least as well, and ground that only the first
  /// image shows, gain nothing.
  double utility = 0;
};

/// Estimates the utility of a pair. The ground is modelled as a plane perpendicular to the optical axis of the first
/// camera at `distance`. Let t be the translation of `second_from_first`, and (x, y) and z the normalised coordinates
/// and the depth of a point in the second camera. A relative change of 1 of the point's distance moves it in the second
/// image by p = f |(t_x - x t_z, t_y - y t_z)| / z. Its relative sigma is that of a disparity, 0.1 px, divided by p.
/// The utility is 0 if less than 0.3 of the image is common.
[[nodiscard]] PairUtility pair_utility(const CameraModel& camera, const RigidTransform& second_from_first,
                                       double distance, const Coverage& coverage, const PairUtilityParams& params);

}  // namespace ilp
