// Rendering along a strip of the default world: without effects, and with each effect alone.
// Times are CPU time of one thread.

#include <benchmark/benchmark.h>

#include <vector>

#include "sim/world/flight.hpp"
#include "sim/world/renderer.hpp"

namespace ilp::sim {
namespace {

std::vector<CameraMotion> strip() {
  FlightParams flight;
  flight.frames = 8;
  flight.interval_s = 10;
  std::vector<CameraMotion> motions;
  for (const CameraState& state : fly(flight)) {
    CameraMotion motion;
    motion.state = state;
    motion.velocity_m_s = Vec3(2.5, 0, 0);
    motion.turn_rad_s = Vec3(0.004, 0.002, 0.006);
    motions.push_back(motion);
  }
  return motions;
}

void render_strip(benchmark::State& state, const CameraEffects& effects) {
  const std::vector<CameraMotion> motions = strip();
  const Terrain terrain{WorldParams()};
  const Renderer renderer(terrain, default_camera(), effects, 1);
  RenderedFrame frame;
  std::size_t k = 0;
  for (auto _ : state) {
    renderer.render(motions[k % motions.size()], static_cast<std::int64_t>(k), frame);
    benchmark::DoNotOptimize(frame.grey.pixels.data());
    ++k;
  }
}

void patch_of_frame(benchmark::State& state) {
  const Terrain terrain{WorldParams()};
  double x = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(terrain.patch({x - 65, -50, x + 65, 50}).height_m.data());
    x += 25;
  }
}

CameraEffects none() {
  return {};
}

}  // namespace

BENCHMARK(patch_of_frame)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(render_strip, effects_off, none())->Unit(benchmark::kMillisecond);

}  // namespace ilp::sim

BENCHMARK_MAIN();
