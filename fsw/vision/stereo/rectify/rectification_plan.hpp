// The plan of a pair's rectification: one panel by homographies, or several panels in polar coordinates.
#pragma once

#include <array>

#include "fsw/vision/stereo/rectify/rectification.hpp"

namespace ilp {

inline constexpr std::size_t max_rectified_panels = 48;

/// A panel is a pair of rectified images that is matched on its own. Every pixel of the left image gets its depth from
/// at most one panel.
struct RectifiedPanel {
  RectifiedPair pair;
  DisparityRange range;
};

struct RectificationPlan {
  RectificationMethod method = RectificationMethod::homography;
  std::array<RectifiedPanel, max_rectified_panels> panels;
  std::size_t count = 0;
  /// There is no depth within an angle about the epipole; this is the angle times the focal length. 0 for homographies.
  double blind_radius_px = 0;
  double resolution = 1;  ///< rectified px per px of the left image, at the pixel where this ratio is smallest
  double baseline = 0;    ///< world units
  /// Largest shift of a point, px of the left image, when its inverse depth changes by 1.
  double disparity_per_inverse_depth_px = 0;
};

/// Plans homographies if they are possible. If the epipole is too near for them, or the images would become too large,
/// it plans polar coordinates (polar_rectification.hpp). Returns the errors and warnings of plan_rectification and
/// plan_polar_rectification; RectificationFault::epipole_near does not occur.
Status plan_panels(const CameraModel& camera, const RigidTransform& left_from_world,
                   const RigidTransform& right_from_world, const DepthRange& depth, const RectificationParams& params,
                   RectificationPlan& plan);

}  // namespace ilp
