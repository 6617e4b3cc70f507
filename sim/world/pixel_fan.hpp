// The directions in which a camera's pixels look, with distortion undone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"

namespace ilp::world {

/// Normalised image coordinates: (X/Z, Y/Z) in the camera.
struct Direction {
  double x = 0, y = 0;
};

/// One pixel: its centre, and the 2x2 samples over which it averages light, a quarter of a pixel off the centre.
struct PixelRays {
  Direction centre;
  std::array<Direction, 4> samples;
};

/// A square of pixels at (u0, v0), cut off at the image's edge.
struct PixelTile {
  std::int32_t u0 = 0, v0 = 0, u1 = 0, v1 = 0;  ///< u1 and v1 exclusive
  std::array<Direction, 4> corners;             ///< their hull holds every sample, with a quarter of a pixel to spare
};

struct PixelFan {
  static constexpr std::int32_t tile_side = 8;

  /// std::invalid_argument for a camera that flight software would refuse.
  explicit PixelFan(const CameraModel& model);

  [[nodiscard]] const PixelRays& at(std::int32_t u, std::int32_t v) const {
    return pixels[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera.width) + static_cast<std::size_t>(u)];
  }

  CameraModel camera;
  std::vector<PixelRays> pixels;  ///< row by row
  std::vector<PixelTile> tiles;   ///< row by row
  std::vector<Direction> border;  ///< the image's outermost edge
};

}  // namespace ilp::world
