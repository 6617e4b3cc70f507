// What the camera sees of the ground, and how far away it is.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/camera_effects.hpp"
#include "sim/world/camera_state.hpp"
#include "sim/world/pixel_fan.hpp"
#include "sim/world/terrain.hpp"

namespace ilp::world {

struct RenderedFrame {
  host::Raster<std::uint8_t> grey;
  host::Raster<float>
      depth_m;  ///< z of the ground in the camera frame, at the centre of every pixel of the (distorted) image; 0: none
};

class Renderer {
 public:
  /// Borrows the terrain. std::invalid_argument for a camera that flight software would refuse, and for an effect out
  /// of its range.
  Renderer(const Terrain& terrain, const CameraModel& camera, const CameraEffects& effects, std::uint64_t seed);

  /// For the next images. Not to be called while one is rendered.
  void set_effects(const CameraEffects& effects) { effects_ = effects; }

  /// Radiance is averaged over 2x2 rays per pixel; grey = 255 L / (L + 1) for a radiance L, so that level ground of
  /// mean albedo is 127 and nothing saturates. The depth is that of an ideal shutter at motion.state, whatever the
  /// effects; the image is altered in the order of the light: motion, haze, clouds, vignetting, point spread, sensor. A
  /// cloud that hides the ground leaves no depth (0). Same seed, index and motion, same bytes. std::runtime_error when
  /// the camera is inside the ground's range of heights or sees the horizon. Safe to call from several threads.
  void render(const CameraMotion& motion, std::int64_t frame_index, RenderedFrame& out) const;

 private:
  struct View;  // one frame's ground
  [[nodiscard]] Rectangle footprint(std::span<const CameraState> states) const;
  void look(const View& view, const CameraState& state, host::Raster<float>& depth_m,
            host::Raster<float>& radiance) const;
  void look_while_moving(const View& view, const CameraMotion& motion, host::Raster<float>& radiance) const;
  void cross_the_haze(const CameraState& state, const host::Raster<float>& depth_m,
                      host::Raster<float>& radiance) const;
  void pass_the_lens(host::Raster<float>& radiance) const;

  const Terrain& terrain_;
  PixelFan fan_;
  CameraEffects effects_;
  std::uint64_t seed_;
};

}  // namespace ilp::world
