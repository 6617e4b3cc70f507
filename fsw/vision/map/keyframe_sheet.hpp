// A keyframe drawn on the map's grid by the pose that it has by the prior: its sheet.
#pragma once

#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Sums of what falls on each cell of the sheet, and how much that was.
struct SheetSums {
  std::int32_t width = 0, height = 0;
  std::int32_t* sum = nullptr;
  std::uint8_t* count = nullptr;
};

/// Draws one image.
class SheetPainter {
 public:
  /// `invalid_argument` (map_keyframe) for an image without its camera's size, and the errors of validate(camera).
  /// `fallback_m`: height of the ground where the map does not know it.
  Status begin(const MapKeyframe& keyframe, const MapPlan& plan, const MapWindow& window, double fallback_m);
  /// Rows [first, last) of the sheet: adds the mean grey of each cell, in sixteenths, less the mean of the image. A
  /// cell that the image does not wholly show, with a margin of half a cell, gets nothing.
  void paint_rows(const MapWindow& window, std::int32_t first, std::int32_t last, const SheetSums& sums) const;
  /// Raw value of a cell that is so much darker than the image that it lies in a shadow.
  [[nodiscard]] std::int32_t darkest_lit() const;

 private:
  /// The pixel of a point in the camera's frame; false when the image does not reach so far.
  [[nodiscard]] bool look(const Vec3& p, Vec2& pixel) const;

  GrayView image_;
  CameraModel camera_;
  bool plain_ = true;
  RigidTransform camera_from_map_;
  std::int32_t first_column_ = 0, first_row_ = 0;  ///< of the sheet in the window
  double fallback_m_ = 0;
  double farthest2_ = 0;        ///< from the optical axis, of what the image shows: squared, at distance 1
  std::int32_t side_ = 16;      ///< of the square of the image that a cell covers, sixteenths of a px
  std::int32_t mean_grey_ = 0;  ///< sixteenths
};

/// Adds the heights above `level_m` of the depths' points to the cells that they lie in, as raw_height() has them. A
/// cell takes the first 255.
void add_depths(const MapKeyframe& keyframe, ImageView<const float> depth_m, double first_px, double step_px,
                const MapPlan& plan, double level_m, std::int32_t first_row, std::int32_t last_row,
                const SheetSums& sums);

/// Means of the sums as raw values; unknown_value where there is nothing.
void finish_sheet(const SheetSums& sums, MapChannels<max_map_sheet_side>& sheet);

/// Cells whose raw value is below `least` are not compared: they become unknown, and directions at them and beside them
/// 0. Shadows lie beside what casts them, all to one side, so that they would draw the place towards the sun.
void hide_dark_cells(std::int32_t least, MapChannels<max_map_sheet_side>& sheet);

}  // namespace ilp
