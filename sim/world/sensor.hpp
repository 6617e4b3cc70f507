// From light to grey levels: exposure, response, noise, dead pixels.
#pragma once

#include <cstdint>

#include "sim/host/image_io.hpp"
#include "sim/world/camera_effects.hpp"

namespace ilp::world {

/// What the frame's radiances are multiplied by: `gain`, times a smooth random function of the frame's index between
/// 1/3 and 3 that changes by no more than the share `gain_step` from one frame to the next.
[[nodiscard]] double frame_gain(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index);

/// grey = 255 L / (L + 1) for a radiance L times the frame's gain, or 127.5 L up to 255 where it `saturates`, plus
/// normal noise of variance grey * 255 / full_well_e (shot) + read_noise_grey^2, rounded; dead pixels keep their own
/// level. Noise depends on the seed, the frame's index and the pixel's number only.
void expose(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index,
            const host::Raster<float>& radiance, host::Raster<std::uint8_t>& grey);

}  // namespace ilp::world
