// Which piece of the map a keyframe is compared with, and at which pixel.
#pragma once

#include <span>

#include "fsw/base/result.hpp"
#include "fsw/vision/map/map_window.hpp"

namespace ilp {

inline constexpr std::int32_t map_least_patch_px = 8;
inline constexpr std::int32_t map_relief_patch_px = 8;

/// Rectangle of whole cells of a grid with this pixel: cell 0 of the window is cell (first_column, first_row) of the
/// grid whose north-west corner is the map's origin.
struct MapPlan {
  double pixel_m = 0;
  std::int32_t search_px = 0;  ///< of shifts to each side, edge included
  std::int32_t patch_px = 0;   ///< side of a patch
  std::int64_t first_column = 0, first_row = 0;
  std::int32_t width = 0, height = 0;
  std::int32_t sheet_width = 0, sheet_height = 0;  ///< of the keyframe on the grid
  std::int32_t sheet_column = 0, sheet_row = 0;    ///< of its first cell in the window: search_px, until it is found

  [[nodiscard]] double x0_m() const { return static_cast<double>(first_column) * pixel_m; }
  [[nodiscard]] double y0_m() const { return -static_cast<double>(first_row) * pixel_m; }
};

/// Pixel of the image on level ground at the height `ground_m`, in the image's middle, m. 0 when the camera does not
/// see it.
[[nodiscard]] double image_pixel_m(const CameraModel& camera, const RigidTransform& camera_from_map, double ground_m);
/// Image pixels in a working pixel, at least: a finer comparison costs more and gains nothing.
inline constexpr double least_map_image_pixels = 4.5;
/// The pixel at which a map is compared: that of the map, but at least least_map_image_pixels, and so much that the
/// image fits into max_map_sheet_side with a margin.
[[nodiscard]] double map_working_pixel_m(const CameraModel& camera, double image_pixel_m, double map_pixel_m);
/// Image pixels in a pixel of relief, at least: depths are those of cells of 8 px. Posts of the map may be farther
/// apart; heights between them are as good as the keyframe's own, and coarser pixels leave too few patches.
inline constexpr double least_relief_image_pixels = 12;
/// The pixel at which relief is compared.
[[nodiscard]] double map_relief_pixel_m(double image_pixel_m, double map_pixel_m);
/// Side of a patch, px, by the number of image pixels in a working pixel: 16, 12 or 8. For relief it is
/// map_relief_patch_px, which the caller puts into the plan.
[[nodiscard]] std::int32_t map_patch_px(double image_pixels);

/// Plans the window about the ground that the keyframes see by the prior, or their middle part. Three standard
/// deviations of the place are searched, at least least_map_search_px. `capacity_exceeded` (a, b: needed and most px)
/// when that needs more than most_map_search_px: a larger working pixel is needed. `not_found` when the camera does not
/// look down on the ground.
Result<MapPlan> plan_map_window(std::span<const MapKeyframe> keyframes, const MapPrior& prior, double ground_m,
                                double pixel_m);

}  // namespace ilp
