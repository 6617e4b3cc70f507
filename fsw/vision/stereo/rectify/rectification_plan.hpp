// How a pair is rectified: as one pair of images by homographies, or as several by polar coordinates.
#pragma once

#include <array>

#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

inline constexpr std::size_t max_rectified_panels = 48;

/// A pair of rectified images, matched on its own. Every pixel of the left image gets its depth from at most one panel.
struct RectifiedPanel {
  RectifiedPair pair;
  DisparityRange range;
};

struct RectificationPlan {
  RectificationMethod method = RectificationMethod::homography;
  std::array<RectifiedPanel, max_rectified_panels> panels;
  std::size_t count = 0;
  /// There is no depth within this angle about the epipole, times the focal length; 0 for homographies.
  double blind_radius_px = 0;
  double resolution = 1;  ///< rectified px per px of the left image, where it is least
  double baseline = 0;
  /// A change of the inverse depth by one moves a point by at most this many px of the left image.
  double disparity_per_inverse_depth_px = 0;
};

/// Plans homographies if they are possible. If the epipoles are too near for them or the images become too large, it
/// plans polar coordinates (polar_rectification.hpp). Errors and warning as plan_rectification and
/// plan_polar_rectification, without b = 3.
Status plan_panels(const CameraModel& camera, const RigidTransform& left_from_world,
                   const RigidTransform& right_from_world, const DepthRange& depth, const RectificationParams& params,
                   RectificationPlan& plan);

}  // namespace ilp
