#include "sim/world/sensor.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fsw/base/math.hpp"
#include "fsw/base/rng.hpp"

namespace ilp::world {
namespace {

constexpr double full_scale = 255;

/// Random streams of a camera.
enum class Stream : std::uint64_t { noise = 1, gain = 2, dead = 3 };

std::uint64_t stream_seed(std::uint64_t seed, Stream stream) {
  return mix64(mix64(seed) + static_cast<std::uint64_t>(stream));
}

/// In [0, 1).
double uniform(std::uint64_t bits) {
  return static_cast<double>(bits >> 11U) * (1.0 / 9007199254740992.0);
}

/// Sum of four uniform numbers, mean 0, variance 1: close to normal, and the same on every machine.
double unit_noise(std::uint64_t bits) {
  const std::uint64_t sum = (bits & 0xFFFFU) + ((bits >> 16U) & 0xFFFFU) + ((bits >> 32U) & 0xFFFFU) + (bits >> 48U);
  constexpr double mean = 4 * 0.5 * (1 - 1.0 / 65536);
  constexpr double sqrt3 = 1.73205080756887729353;
  return (static_cast<double>(sum) * (1.0 / 65536.0) - mean) * sqrt3;
}

std::uint8_t to_level(double grey) {
  return static_cast<std::uint8_t>(std::clamp(std::floor(grey + 0.5), 0.0, full_scale));
}

void kill_pixels(double share, std::uint64_t seed, host::Raster<std::uint8_t>& grey) {
  for (std::size_t pixel = 0; pixel < grey.samples.size(); ++pixel) {
    const std::uint64_t bits = mix64(seed ^ pixel);
    if (uniform(bits) < share) grey.samples[pixel] = static_cast<std::uint8_t>(bits & 0xFFU);
  }
}

}  // namespace

double frame_gain(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index) {
  if (effects.gain_step <= 0) return effects.gain;
  const double bound = det_log(3);
  // A smooth step of height 2 bound is steepest in its middle: 15/8 of its mean slope.
  const double frames_per_cell = 15.0 / 8 * 2 * bound / det_log(1 + effects.gain_step);
  const double place = static_cast<double>(frame_index) / frames_per_cell;
  const double cell = std::floor(place);
  const double t = place - cell;
  const std::uint64_t base = stream_seed(seed, Stream::gain);
  const auto level = [&](double k) {
    const auto id = static_cast<std::uint64_t>(static_cast<std::int64_t>(k));
    return bound * (2 * uniform(mix64(base + id)) - 1);
  };
  const double before = level(cell);
  const double fade = t * t * t * (t * (t * 6 - 15) + 10);
  return effects.gain * det_exp(before + (level(cell + 1) - before) * fade);
}

void expose(const CameraEffects& effects, std::uint64_t seed, std::int64_t frame_index,
            const host::Raster<float>& radiance, host::Raster<std::uint8_t>& grey) {
  const double gain = frame_gain(effects, seed, frame_index);
  const double shot_variance = effects.shot_noise ? full_scale / effects.full_well_e : 0;
  const double read_variance = effects.read_noise_grey * effects.read_noise_grey;
  const bool noisy = shot_variance > 0 || read_variance > 0;
  const std::uint64_t noise_seed = mix64(stream_seed(seed, Stream::noise) + static_cast<std::uint64_t>(frame_index));
  for (std::size_t pixel = 0; pixel < radiance.samples.size(); ++pixel) {
    const double light = gain * static_cast<double>(radiance.samples[pixel]);
    double level =
        effects.saturates ? std::min(0.5 * full_scale * light, full_scale) : full_scale * light / (light + 1);
    if (noisy) level += std::sqrt(shot_variance * level + read_variance) * unit_noise(mix64(noise_seed ^ pixel));
    grey.samples[pixel] = to_level(level);
  }
  if (effects.dead_pixel_share > 0) kill_pixels(effects.dead_pixel_share, stream_seed(seed, Stream::dead), grey);
}

}  // namespace ilp::world
