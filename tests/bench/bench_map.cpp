// Registration of a keyframe against an orbital map, beside the detection of its corners: one run gives the ratio.
#include <benchmark/benchmark.h>

#include <memory>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/harris.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "tests/unit/vision/map/map_world.hpp"

namespace ilp {
namespace {

/// A keyframe of 640 x 480 px over cratered plains.
struct Scene {
  test::MapWorld world{"mars-plains", 1};
  test::MapTrial trial;
  test::OrbitalMap near, far;

  Scene() {
    test::OrbitalMapParams params;
    params.pixel_m = 3 * world.image_pixel_m();
    near = world.map(34 * pi / 180, params);
    far = world.map(pi / 2, params);
    Rng rng(1, 5);
    world.look_anywhere({.place_share = 0.05}, rng, trial);
  }
};
Scene& scene() {
  static Scene made;
  return made;
}

void corners(benchmark::State& state) {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  static const auto found = std::make_unique<Corners>();
  const GrayView image = scene().trial.frame.grey.view();
  for (auto _ : state) {
    benchmark::DoNotOptimize(detect_corners(image, {}, *workspace, *found));
  }
}
BENCHMARK(corners)->Unit(benchmark::kMillisecond);

/// Arguments: shifts to each side that the prior asks for, px; whether the map's sun is far from that of the keyframe.
void register_keyframe(benchmark::State& state) {
  const test::OrbitalMap& map = state.range(1) == 0 ? scene().near : scene().far;
  test::MapTrial trial = scene().trial;
  MapPlan plan = test::plan_of(trial, map);
  const double sigma_m = static_cast<double>(state.range(0)) / 3.1 * plan.pixel_m;
  const double by_attitude_m = 0.0087 * scene().world.altitude_m();
  trial.prior.covariance(3, 3) = trial.prior.covariance(4, 4) = sigma_m * sigma_m - by_attitude_m * by_attitude_m;
  plan = test::plan_of(trial, map);
  test::WindowStore store;
  const MapWindow window = store.fill(map, plan);
  const MapRegistrationInput input{plan, window, trial.prior, {&trial.keyframe, 1}, scene().world.sun(), nullptr};
  const auto workspace = std::make_unique<MapRegistrationWorkspace>();
  const auto registration = std::make_unique<MapRegistration>();
  std::int64_t slices = 0;
  for (auto _ : state) {
    if (!registration->begin(input, {}, *workspace).ok()) state.SkipWithError("begin");
    slices = 1;
    while (registration->step().value()) ++slices;
  }
  state.SetLabel(name_of(registration->result().verdict));
  state.counters["search_px"] = plan.search_px;
  state.counters["slices"] = static_cast<double>(slices);
  state.counters["patches"] = registration->result().patches;
  state.counters["kept_bytes"] = sizeof(MapRegistrationWorkspace) + sizeof(MapRegistration);
}
BENCHMARK(register_keyframe)
    ->Args({16, 0})
    ->Args({24, 0})
    ->Args({40, 0})
    ->Args({16, 1})
    ->Args({24, 1})
    ->Args({40, 1})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
