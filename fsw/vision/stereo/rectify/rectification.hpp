// Two images resampled so that matching points share a row: by homographies, which turn both cameras to a common
// orientation (A. Fusiello, E. Trucco, A. Verri, "A compact algorithm for rectification of stereo pairs", Machine
// Vision and Applications 12, 2000), or in polar coordinates about the baseline (polar_rectification.hpp).
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"

namespace ilp {

/// Depth along the reference camera's optical axis, in units of the world.
struct DepthRange {
  double nearest = 0;
  double farthest = 0;
};

/// Range of the depths of world points in a camera, without the `outlier_share` at either end, widened on both sides by
/// the share `margin`. Points behind the camera do not count. `too_few_matches` when fewer than 8 remain.
Status depth_range_of(const RigidTransform& cam_from_world, const Vec3* points_world, std::size_t count,
                      double outlier_share, double margin, DepthRange& range);

struct RectificationParams {
  double max_axes_angle_rad = 1.05;  ///< between the optical axes: beyond it the views hardly share ground
  double max_turn_rad = 0.87;  ///< of either optical axis: the rest up to 90 degrees is left to the image's half angle
  double min_scale = 0.5;      ///< of the focal length: this much resolution may be lost to fit the limits
  double scale = 1;            ///< factor on the resolution and on its limits: a smaller one is coarser and faster
  double margin_px = 2;        ///< added to the disparities at both ends of the range
  double polar_scale = 0.75;   ///< px per px of the image at a ring's outer edge; its inner edge then has 1.7 at most
  double min_parallax_px = 4;  ///< polar: ground that moves less gets no depth; 0.2 px of error in 4 px is 5 % of depth
};

/// Box of normalised coordinates (X/Z, Y/Z) inside which a camera's distortion may be applied.
struct FieldOfView {
  double min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};
[[nodiscard]] FieldOfView field_of_view(const CameraModel& camera);

enum class RectificationMethod : std::uint8_t { homography, polar };

/// Part of the directions around the baseline, low <= value < high.
struct PolarSector {
  double low_cotangent = 0, high_cotangent = 0;  ///< of the angle from the baseline
  double low_azimuth = 0, high_azimuth = 0;      ///< rad
};

/// Both methods look along axes x, y, z: x runs from the left camera's centre to the right one's. A pixel of direction
/// q in these axes has column and row
///   homography  focal_px q_x / q_z + cx,        focal_px q_y / q_z + cy
///   polar       focal_px asinh(cot a) + cx,     focal_px atan2(q_y, q_z) + cy    with cot a = q_x / |(q_y, q_z)|
/// so that x_left - x_right - disparity_offset_px() is focal_px * baseline / Z (homography; Z is the depth along z) or
/// a function of the column and the distance of the point (polar; depth.hpp). The left camera is the reference. A
/// rectified image may have any angle to the original.
struct RectifiedPair {
  RectificationMethod method = RectificationMethod::homography;
  std::int32_t width = 0, height = 0;  ///< px, of both images
  double focal_px = 0;                 ///< polar: px per radian of azimuth
  double cx_left = 0, cx_right = 0, cy = 0;
  double baseline = 0;  ///< units of the world
  Mat3 rect_from_left = Mat3::Identity(), rect_from_right = Mat3::Identity();
  FieldOfView field_of_view;
  PolarSector sector;     ///< polar: what this pair gives depth for; its images reach a little further
  double resolution = 1;  ///< rectified px per px of the left image, where it is least

  [[nodiscard]] double disparity_offset_px() const { return cx_left - cx_right; }
};

/// Plans by homographies. The pair is cropped to the common rows and to the columns that can have a match. Errors:
/// `rectification_impossible` (b = RectificationFault); `invalid_argument` for an empty depth range.
/// `disparity_range_exceeded` is a warning: pair and range are usable, but the near end of the range was cut.
Status plan_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                          const RigidTransform& right_from_world, const DepthRange& depth,
                          const RectificationParams& params, RectifiedPair& pair, DisparityRange& range);

/// Rectified pixel of the direction `normalised` (X/Z, Y/Z) of the left or right camera; polar rows are those nearest
/// to the image, as an azimuth has many.
[[nodiscard]] Vec2 rectified_left(const RectifiedPair& pair, const Vec2& normalised);
[[nodiscard]] Vec2 rectified_right(const RectifiedPair& pair, const Vec2& normalised);
/// True if this pair gives depth for the direction `normalised` of the left camera. Homographies do for all directions.
[[nodiscard]] bool gives_depth(const RectifiedPair& pair, const Vec2& normalised);

}  // namespace ilp
