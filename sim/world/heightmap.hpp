// Ground that a user brings: heights or brightness on the pixels of a file.
#pragma once

#include <filesystem>
#include <optional>

#include "sim/host/image_io.hpp"
#include "sim/world/world_params.hpp"

namespace ilp::world {

/// Values on posts, bilinear between them and mirrored at its borders without end: no cliff, no repeated seam. The
/// image's x axis runs along the world's x, its rows from the largest y down, as maps lie.
class Heightmap {
 public:
  /// Every value finite, at least 2x2 of them, spacings positive; std::invalid_argument otherwise. (first_x, first_y)
  /// is the place of the first row's first pixel, m.
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

/// The maps that a world names. A brightness file without a spacing of its own covers the rectangle of the heights; one
/// that knows its place, as the heights do, moves with them.
struct ImportedGround {
  std::optional<Heightmap> heights;     ///< m
  std::optional<Heightmap> brightness;  ///< mean 1
};

/// std::runtime_error names the file and what is wrong: not readable, holes (how many) unless `fill_holes`, no spacing.
[[nodiscard]] ImportedGround load_ground(const WorldParams& world);

/// Gives every pixel that is not finite the mean of its neighbours, from the holes' rims inwards. False when all are
/// holes.
bool fill_holes(host::Raster<float>& values);

}  // namespace ilp::world
