// Inputs and results of the registration of keyframes against an orbital map.
//
// Map frame: x east, y north, z up, m. Grid of a window: row 0 is the northern edge; cell (column, row) has its centre
// at x = x0_m + (column + 0.5) pixel_m, y = y0_m - (row + 0.5) pixel_m. `px` means a cell of this grid (the working
// pixel) unless a comment says otherwise.
#pragma once

#include <cstdint>

#include "cfg/limits.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/verdicts.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {

using PoseCovariance = Eigen::Matrix<double, 6, 6>;
using Mat2 = Eigen::Matrix2d;

inline constexpr std::int32_t max_map_window_side = 256;  ///< px
inline constexpr std::int32_t max_map_sheet_side = 176;   ///< px, of the keyframe on the map's grid
inline constexpr std::int32_t map_edge_px = 4;  ///< margin of the search range: a peak within it is not accepted
inline constexpr std::int32_t least_map_search_px = 16;
inline constexpr std::int32_t most_map_search_px = 40;
inline constexpr std::int32_t max_map_shift_px = most_map_search_px + map_edge_px;

/// A part of the map that the caller has resampled to the working pixel. Cells beyond the map are unknown. The arrays
/// have `width * height` values, row by row.
struct MapWindow {
  std::int32_t width = 0, height = 0;   ///< px, at most max_map_window_side
  double pixel_m = 0;                   ///< the working pixel
  double x0_m = 0, y0_m = 0;            ///< north-west corner
  const std::uint8_t* image = nullptr;  ///< 0: unknown. Null: a map without an image
  const float* height_m = nullptr;      ///< finite everywhere; any finite value where unknown
  const std::uint8_t* known = nullptr;  ///< 0: the height is unknown
  double ground_m = 0;                  ///< height of the ground where it is unknown
  bool image_is_flat = false;           ///< the image was already divided by its shading
  double sun_azimuth_rad = 0;           ///< of the image; direction towards the sun, from x towards y
  double sun_elevation_rad = 0;         ///< above the horizon
};

/// Direction towards the sun at the exposure; angles as in MapWindow.
struct SunDirection {
  double azimuth_rad = 0, elevation_rad = 0;
};

/// A small change of a pose camera_from_map: first the rotation vector w in the camera, R' = exp([w]x) R, rad, then the
/// displacement of the camera's centre in the map, m. Covariances of poses have this order.
struct MapPrior {
  RigidTransform camera_from_map;
  PoseCovariance covariance = PoseCovariance::Zero();
  bool attitude_is_measured = false;  ///< by the vehicle; the fix then uses the attitude and its covariance
};

/// An image and its prior pose. The poses of keyframes that are registered together belong to the same prior: their
/// relative poses are those of the strip.
struct MapKeyframe {
  GrayView image;
  CameraModel camera;
  RigidTransform camera_from_map;
};

/// A point of the map at which a patch of the keyframe was found.
struct MapFixPoint {
  float u_px = 0, v_px = 0;         ///< in the (first) keyframe, ideal px
  float column_px = 0, row_px = 0;  ///< in the window
  float height_m = 0;
  float residual_px = 0;  ///< distance from the point that the pose predicts, working px
};

struct MapFixResult {
  MapVerdict verdict = MapVerdict::no_map;
  MapSense sense = MapSense::relit;
  double ground_m[3] = {0, 0, 0};  ///< where the optical axis of the (first) keyframe meets the ground
  Mat2 ground_covariance = Mat2::Zero();
  RigidTransform camera_from_map;
  PoseCovariance covariance = PoseCovariance::Zero();
  double evidence = 0;                                            ///< vote_evidence() of the votes
  std::int32_t patches = 0, votes = 0, rivals = 0, quarters = 0;  ///< as in MapVote
  double shift_px[2] = {0, 0};  ///< shift of the keyframe's ground from the prior: columns, rows
  double shift_sigmas = 0;      ///< the same in standard deviations of the prior
  double residual_px = 0;       ///< RMS of the points' residuals per axis, working px
  FixedVector<MapFixPoint, limits::max_fix_points> points;
};

}  // namespace ilp
