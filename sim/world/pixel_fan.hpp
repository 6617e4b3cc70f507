// Computes the lines of sight of a camera's pixels, without distortion.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"

namespace ilp::world {

/// Normalised image coordinates (X/Z, Y/Z) in the camera frame.
struct Direction {
  double x = 0, y = 0;
};

/// The directions of a pixel's centre, and of the 2x2 samples over which light is averaged, a quarter of a pixel from
/// the centre in x and y.
struct PixelRays {
  Direction centre;
  std::array<Direction, 4> samples;
};

/// A square of tile_side x tile_side pixels from (u0, v0) on, cut at the image's edge.
struct PixelTile {
  std::int32_t u0 = 0, v0 = 0, u1 = 0, v1 = 0;  ///< u1 and v1 exclusive
  std::array<Direction, 4> corners;  ///< outer corners: their hull contains every sample with a margin of 1/4 px
};

struct PixelFan {
  static constexpr std::int32_t tile_side = 8;

  /// Throws std::invalid_argument for a camera that flight software would refuse.
  explicit PixelFan(const CameraModel& model);

  [[nodiscard]] const PixelRays& at(std::int32_t u, std::int32_t v) const {
    return pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)];
  }

  CameraModel camera;
  std::vector<PixelRays> pixels;  ///< row by row
  std::vector<PixelTile> tiles;   ///< row by row
  std::vector<Direction> border;  ///< points on the image's outer edge, one per pixel corner
};

}  // namespace ilp::world
