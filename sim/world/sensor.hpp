// Converts light to grey levels: exposure, response, noise, dead pixels.
#pragma once

#include <cstdint>

#include "sim/host/image_io.hpp"
#include "sim/world/camera_effects.hpp"

namespace ilp::world {

/// Factor on the radiances of a frame: `gain` times a smooth random function of the frame's index. This function is
/// between 1/3 and 3 and changes by at most the share `gain_step` from frame to frame.
[[nodiscard]] double frame_gain(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index);

/// Computes grey = 255 L / (L + 1), or min(127.5 L, 255) with `saturates`, where L is the radiance times the frame's
/// gain. Adds nearly normal noise with the variance grey * 255 / full_well_e (shot noise) + read_noise_grey^2 and
/// rounds. Dead pixels have constant levels. Noise depends on the seed, the frame's index and the pixel's index only.
void expose(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index,
            const host::Raster<float>& radiance, host::Raster<std::uint8_t>& grey);

}  // namespace ilp::world
