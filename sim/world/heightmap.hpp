// Reads heights and brightness of the ground from a user's files.
#pragma once

#include <filesystem>
#include <optional>

#include "sim/host/image_io.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

/// Values at posts with bilinear interpolation. Beyond its borders the map is mirrored repeatedly, so that there are no
/// cliffs. Columns are along the world's x axis; y decreases from row to row.
class Heightmap {
 public:
  /// (first_x_m, first_y_m) is the position of the first pixel of the first row. Throws std::invalid_argument that
  /// begins with `name` for values that are not finite, for fewer than 2x2 values, and for spacings that are not
  /// positive.
  Heightmap(host::Raster<float> values, double spacing_x_m, double spacing_y_m, double first_x_m, double first_y_m,
            const std::string& name = "heightmap");

  [[nodiscard]] double at(double x, double y) const;
  [[nodiscard]] double lowest() const { return lowest_; }
  [[nodiscard]] double highest() const { return highest_; }
  [[nodiscard]] double mean() const { return mean_; }
  [[nodiscard]] const host::Raster<float>& values() const { return values_; }
  [[nodiscard]] double first_x() const { return first_x_; }
  [[nodiscard]] double first_y() const { return first_y_; }
  [[nodiscard]] double width_m() const { return (values_.width - 1) * spacing_x_; }
  [[nodiscard]] double height_m() const { return (values_.height - 1) * spacing_y_; }

 private:
  host::Raster<float> values_;
  double spacing_x_, spacing_y_, first_x_, first_y_;
  double lowest_ = 0, highest_ = 0, mean_ = 0;
};

/// The maps of a world. A brightness map without a spacing covers the rectangle of the heights. A brightness map keeps
/// its position relative to the heights if both have a georeference.
struct ImportedGround {
  std::optional<Heightmap> heights;     ///< m; empty: none named
  std::optional<Heightmap> brightness;  ///< mean 1; empty: none named
};

/// Reads the maps that the world names. Throws std::runtime_error that names the file if it cannot be read, has pixels
/// without a value (unless `fill_holes`) or no spacing.
[[nodiscard]] ImportedGround load_ground(const WorldParams& world);

/// Fills pixels that are not finite with the mean of their neighbours, from the borders of the holes inwards. Returns
/// false if no pixel is finite.
bool fill_holes(host::Raster<float>& values);

}  // namespace ilp::world
