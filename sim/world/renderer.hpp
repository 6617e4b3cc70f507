// Renders images of the ground and their depths.
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
  /// Keeps a reference to the terrain. Throws std::invalid_argument for a camera that flight software would refuse, and
  /// for an effect out of range.
  Renderer(const Terrain& terrain, const CameraModel& camera, const CameraEffects& effects, std::uint64_t seed);

  /// Sets the effects for the next images. Must not be called while an image is rendered.
  void set_effects(const CameraEffects& effects) { effects_ = effects; }

  /// Renders the image and the depths of a frame. Radiance is averaged over 2x2 rays per pixel. Grey levels are those
  /// of `expose` (sensor.hpp): level ground of mean albedo has 127. The effects change the image in the order of the
  /// light's path: motion, haze, clouds, vignetting, point spread, sensor. The depth is always that of an ideal shutter
  /// at motion.state; it is 0 if a cloud hides the ground. The same seed, index and motion give the same bytes. Throws
  /// std::runtime_error if the camera is not above the highest ground or sees the horizon. Thread-safe.
  void render(const CameraMotion& motion, std::int64_t frame_index, RenderedFrame& out) const;

 private:
  struct View;  // the ground of one frame
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
