// Draws a keyframe on the map's grid with its prior pose. The drawing is called the sheet.
#pragma once

#include "fsw/vision/map/map_plan.hpp"
#include "fsw/vision/map/map_window.hpp"
#include "fsw/vision/map/map_workspace.hpp"

namespace ilp {

/// Sum and number of the values in each cell of the sheet.
struct SheetSums {
  std::int32_t width = 0, height = 0;
  std::int32_t* sum = nullptr;
  std::uint8_t* count = nullptr;
};

/// Draws one image on a sheet.
class SheetPainter {
 public:
  /// `fallback_m`: height of the ground where the map's is unknown. Returns `image_size_changed` if the image does not
  /// have its camera's size, `invalid_argument` (map_keyframe) if the camera does not look down on the ground, and the
  /// errors of validate(camera).
  Status begin(const MapKeyframe& keyframe, const MapPlan& plan, const MapWindow& window, double fallback_m);
  /// Adds to each cell of rows [first, last) of the sheet its mean grey minus the image's mean grey, in sixteenths. A
  /// cell that is not completely inside the image gets nothing.
  void paint_rows(const MapWindow& window, std::int32_t first, std::int32_t last, const SheetSums& sums) const;
  /// Raw value below which a cell lies in a shadow.
  [[nodiscard]] std::int32_t darkest_lit() const;

 private:
  /// Projects a point of the camera frame. Returns false if it is too far from the optical axis for the image.
  [[nodiscard]] bool look(const Vec3& p, Vec2& pixel) const;

  GrayView image_;
  CameraModel camera_;
  bool plain_ = true;
  RigidTransform camera_from_map_;
  std::int32_t first_column_ = 0, first_row_ = 0;  ///< position of the sheet in the window
  double fallback_m_ = 0;
  double farthest2_ = 0;        ///< largest squared distance from the optical axis in the image, normalised
  std::int32_t side_ = 16;      ///< side of the square of the image that a cell covers, sixteenths of a px
  std::int32_t mean_grey_ = 0;  ///< sixteenths
};

/// Adds the points of the depths' rows [first_row, last_row) to their cells, as raw_height() above `level_m`. A cell
/// takes the first 255.
void add_depths(const MapKeyframe& keyframe, ImageView<const float> depth_m, double first_px, double step_px,
                const MapPlan& plan, double level_m, std::int32_t first_row, std::int32_t last_row,
                const SheetSums& sums);

/// Writes the mean of each cell as a raw value; unknown_value if the cell is empty.
void finish_sheet(const SheetSums& sums, MapChannels<max_map_sheet_side>& sheet);

/// Excludes cells with a raw value below `least` from the comparison: they become unknown, and the directions of these
/// cells and their neighbours become 0. Shadows are all displaced to the same side of the objects that cast them, and
/// would bias the position.
void hide_dark_cells(std::int32_t least, MapChannels<max_map_sheet_side>& sheet);

}  // namespace ilp
