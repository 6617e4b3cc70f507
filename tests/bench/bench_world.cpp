// Rendering along a strip of the default world: without effects, and with each effect alone.
// Times are CPU time of one thread.

#include <benchmark/benchmark.h>

#include <vector>

#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"

namespace ilp::world {
namespace {

std::vector<world::CameraMotion> strip() {
  world::FlightParams flight{.frames = 8, .interval_s = 10};
  std::vector<world::CameraMotion> motions;
  for (const world::CameraState& state : world::fly(flight)) {
    world::CameraMotion motion{
        .state = state, .velocity_m_s = Vec3(2.5, 0, 0), .turn_rad_s = Vec3(0.004, 0.002, 0.006)};
    motions.push_back(motion);
  }
  return motions;
}

void render_strip(benchmark::State& state, const CameraEffects& effects) {
  const std::vector<world::CameraMotion> motions = strip();
  const world::Terrain terrain{world::WorldParams()};
  const world::Renderer renderer(terrain, world::default_camera(), effects, 1);
  world::RenderedFrame frame;
  std::size_t k = 0;
  for (auto _ : state) {
    renderer.render(motions[k % motions.size()], static_cast<std::int64_t>(k), frame);
    benchmark::DoNotOptimize(frame.grey.samples.data());
    ++k;
  }
}

void patch_of_frame(benchmark::State& state) {
  const world::Terrain terrain{world::WorldParams()};
  double x = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(terrain.patch({x - 65, -50, x + 65, 50}).height_m.data());
    x += 25;
  }
}

template <typename Value>
CameraEffects with(Value CameraEffects::*field, Value value) {
  CameraEffects effects;
  effects.*field = value;
  return effects;
}

void rolling_and_blurred(benchmark::State& state) {
  CameraEffects effects{.exposure_s = 0.05, .readout_s = 0.03};
  render_strip(state, effects);
}

}  // namespace

BENCHMARK(patch_of_frame)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, effects_off, CameraEffects())->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, vignetting, with(&CameraEffects::vignetting, 0.4))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, motion_blur_1px, with(&CameraEffects::exposure_s, 0.07))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, motion_blur_20px, with(&CameraEffects::exposure_s, 1.4))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, rolling_shutter, with(&CameraEffects::readout_s, 0.03))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, point_spread, with(&CameraEffects::psf_sigma_px, 0.7))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, gain_walk, with(&CameraEffects::gain_step, 0.1))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, shot_noise, with(&CameraEffects::shot_noise, true))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, read_noise, with(&CameraEffects::read_noise_grey, 1.5))->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, dead_pixels, with(&CameraEffects::dead_pixel_share, 0.001))
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, haze, with(&CameraEffects::haze, 0.3))->Unit(benchmark::kMillisecond);
BENCHMARK(rolling_and_blurred)->Unit(benchmark::kMillisecond);

}  // namespace ilp::world

BENCHMARK_MAIN();
