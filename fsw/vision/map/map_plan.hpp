// Plans which part of the map a keyframe is compared with, and at which working pixel.
#pragma once

#include <span>

#include "fsw/base/result.hpp"
#include "fsw/vision/map/map_window.hpp"

namespace ilp {

inline constexpr std::int32_t map_least_patch_px = 8;
inline constexpr std::int32_t map_relief_patch_px = 8;

/// A rectangle of cells of the map's grid with this pixel. The first cell of the window is cell (first_column,
/// first_row) of the grid; the north-west corner of the grid's cell (0, 0) is the map's origin.
struct MapPlan {
  double pixel_m = 0;
  std::int32_t search_px = 0;  ///< largest shift to each side, including map_edge_px
  std::int32_t patch_px = 0;   ///< side of a patch
  std::int64_t first_column = 0, first_row = 0;
  std::int32_t width = 0, height = 0;
  std::int32_t sheet_width = 0, sheet_height = 0;  ///< size of the keyframe on the grid
  std::int32_t sheet_column = 0, sheet_row = 0;    ///< its first cell in the window; search_px at first

  [[nodiscard]] double x0_m() const { return static_cast<double>(first_column) * pixel_m; }
  [[nodiscard]] double y0_m() const { return -static_cast<double>(first_row) * pixel_m; }
};

/// Size of the image's middle pixel on level ground at the height `ground_m`, m. 0 if the camera does not look down on
/// that ground.
[[nodiscard]] double image_pixel_m(const CameraModel& camera, const RigidTransform& camera_from_map, double ground_m);
/// Least ratio of the working pixel to the image's pixel: a finer comparison costs more and gains nothing.
inline constexpr double least_map_image_pixels = 4.5;
/// The working pixel for comparing images, m: the map's pixel, or a larger one if the ratio least_map_image_pixels
/// needs it, or if the image would not fit into max_map_sheet_side with a margin.
[[nodiscard]] double map_working_pixel_m(const CameraModel& camera, double image_pixel_m, double map_pixel_m);
/// Least ratio of the working pixel to the image's pixel for relief: depths belong to cells of 8 px. The map's heights
/// may be farther apart than the working pixel: interpolated heights are as accurate as the keyframe's own, and larger
/// pixels leave too few patches.
inline constexpr double least_relief_image_pixels = 12;
/// The working pixel for comparing relief, m.
[[nodiscard]] double map_relief_pixel_m(double image_pixel_m, double map_pixel_m);
/// Side of a patch (16, 12 or 8 px) for a ratio of the working pixel to the image's pixel. For relief it is
/// map_relief_patch_px, which the caller puts into the plan.
[[nodiscard]] std::int32_t map_patch_px(double image_pixels);

/// Plans the window around the ground that the keyframes see according to the prior, or around the middle of it if it
/// is too large. The search range is three standard deviations of the ground position, at least least_map_search_px.
/// Returns `capacity_exceeded` (a, b: needed and largest px) if that is more than most_map_search_px: a larger working
/// pixel is needed. Returns `not_found` if a camera does not look down on the ground, `invalid_argument` if the pixel
/// is invalid or there is no keyframe, and the errors of validate(camera).
Result<MapPlan> plan_map_window(std::span<const MapKeyframe> keyframes, const MapPrior& prior, double ground_m,
                                double pixel_m);

}  // namespace ilp
