// Plans the resampling of two images so that matching points share a row. Homographies turn both cameras to a common
// orientation (A. Fusiello, E. Trucco, A. Verri, "A compact algorithm for rectification of stereo pairs", Machine
// Vision and Applications 12, 2000); the alternative are polar coordinates about the baseline
// (polar_rectification.hpp).
#pragma once

#include <cstdint>

#include "fsw/base/geometry.hpp"
#include "fsw/base/status.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/stereo/disparity_range.hpp"

namespace ilp {

/// Range of depths along the reference camera's optical axis, world units.
struct DepthRange {
  double nearest = 0;
  double farthest = 0;
};

/// Computes the range of the depths of world points in a camera. The share `outlier_share` of the points is left out at
/// either end, and the range is then widened at both ends by `margin` times its length. Points behind the camera do not
/// count. Returns `too_few_matches` if fewer than 8 points are in front of the camera.
Status depth_range_of(const RigidTransform& cam_from_world, const Vec3* points_world, std::size_t count,
                      double outlier_share, double margin, DepthRange& range);

struct RectificationParams {
  /// Largest angle between the optical axes; at larger angles the views hardly share ground.
  double max_axes_angle_rad = 1.05;
  /// Largest turn of either optical axis; the rest up to 90 degrees is for half the field of view.
  double max_turn_rad = 0.87;
  /// Least ratio of the rectified focal length to the image's, when the pair is reduced to fit the limits.
  double min_scale = 0.5;
  double scale = 1;      ///< factor on the resolution and on its limits; below 1 the pair is coarser and faster
  double margin_px = 2;  ///< added to the disparities at both ends of the range
  /// Polar: rectified px per image px at a ring's outer edge; at its inner edge there are at most 1.7.
  double polar_scale = 0.75;
  /// Polar: ground with less parallax gets no depth; an error of 0.2 px in 4 px is 5 % of the depth.
  double min_parallax_px = 4;
};

/// Box of normalised coordinates (X/Z, Y/Z) in which a camera's distortion model is valid.
struct FieldOfView {
  double min_x = 0, max_x = 0, min_y = 0, max_y = 0;
};
[[nodiscard]] FieldOfView field_of_view(const CameraModel& camera);

enum class RectificationMethod : std::uint8_t { homography, polar };

/// A sector of the directions around the baseline: low <= value < high.
struct PolarSector {
  double low_cotangent = 0, high_cotangent = 0;  ///< cotangent of the angle from the baseline
  double low_azimuth = 0, high_azimuth = 0;      ///< rad
};

/// The geometry of a rectified pair. Both methods use axes x, y, z, where x points from the left camera's centre to the
/// right one's. A direction q in these axes has column and row
///   homography  focal_px q_x / q_z + cx,        focal_px q_y / q_z + cy
///   polar       focal_px asinh(cot a) + cx,     focal_px atan2(q_y, q_z) + cy    with cot a = q_x / |(q_y, q_z)|
/// The difference x_left - x_right - disparity_offset_px() is focal_px * baseline / Z for homographies, where Z is the
/// depth along z. For polar coordinates it is a function of the column and the distance of the point (depth.hpp). The
/// left camera is the reference. A rectified image may be rotated by any angle against the original.
struct RectifiedPair {
  RectificationMethod method = RectificationMethod::homography;
  std::int32_t width = 0, height = 0;  ///< size of both rectified images, px
  double focal_px = 0;                 ///< polar: px per radian of azimuth
  double cx_left = 0, cx_right = 0, cy = 0;
  double baseline = 0;  ///< world units
  Mat3 rect_from_left = Mat3::Identity(), rect_from_right = Mat3::Identity();
  FieldOfView field_of_view;
  PolarSector sector;     ///< polar: directions that this pair gives depth for; its images extend a little beyond
  double resolution = 1;  ///< rectified px per px of the left image, at the pixel where this ratio is smallest

  [[nodiscard]] double disparity_offset_px() const { return cx_left - cx_right; }
};

/// Plans a rectification by homographies. The pair is cropped to the common rows and to the columns that can have a
/// match. Returns `rectification_impossible` (b = RectificationFault) if the geometry does not allow it,
/// `invalid_argument` if the depth range is empty. `disparity_range_exceeded` is a warning: pair and range are usable,
/// but the near end of the range was cut.
Status plan_rectification(const CameraModel& camera, const RigidTransform& left_from_world,
                          const RigidTransform& right_from_world, const DepthRange& depth,
                          const RectificationParams& params, RectifiedPair& pair, DisparityRange& range);

/// Returns the rectified pixel of the direction `normalised` (X/Z, Y/Z) of the left or right camera. A polar azimuth
/// has several rows; the result is the one nearest to the middle of the image.
[[nodiscard]] Vec2 rectified_left(const RectifiedPair& pair, const Vec2& normalised);
[[nodiscard]] Vec2 rectified_right(const RectifiedPair& pair, const Vec2& normalised);
/// Returns true if this pair gives depth for the direction `normalised` of the left camera; for homographies always.
[[nodiscard]] bool gives_depth(const RectifiedPair& pair, const Vec2& normalised);

}  // namespace ilp
