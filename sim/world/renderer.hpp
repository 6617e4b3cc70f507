// What the camera sees of the ground, and how far away it is.
#pragma once

#include <cstdint>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "sim/io/image_io.hpp"
#include "sim/world/camera_effects.hpp"
#include "sim/world/camera_state.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::sim {

struct RenderedFrame {
  Image<std::uint8_t> grey;
  Image<float> depth_m;  ///< z of the ground in the camera frame, at the centre of every pixel of the (distorted) image
};

class Renderer {
 public:
  /// Borrows the terrain. std::invalid_argument for a camera that flight software would refuse.
  Renderer(const Terrain& terrain, const CameraModel& camera, const CameraEffects& effects, std::uint64_t seed);

  /// Radiance is averaged over 2x2 rays per pixel; grey = 255 L / (L + 1) for a radiance L, so that level ground of
  /// mean albedo is 127 and nothing saturates. Noise depends on the seed, the frame's index and the pixel only.
  /// std::runtime_error when the camera is inside the ground's range of heights or sees the horizon. Safe to call from
  /// several threads.
  void render(const CameraMotion& motion, std::int64_t frame_index, RenderedFrame& out) const;

 private:
  struct Direction {
    double x, y;  // X/Z, Y/Z in the camera
  };
  static constexpr std::size_t rays_per_pixel = 5;  // four of the 2x2 samples, one at the centre for the depth

  [[nodiscard]] Rectangle footprint(const CameraState& state) const;

  const Terrain& terrain_;
  CameraModel camera_;
  CameraEffects effects_;
  std::uint64_t seed_;
  std::vector<Direction> rays_;    // rays_per_pixel for each pixel, row by row
  std::vector<Direction> border_;  // of the image, outermost
};

}  // namespace ilp::sim
