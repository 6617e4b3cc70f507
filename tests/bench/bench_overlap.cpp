// Overlap of a pair of 640x480 images, and its parts.
#include <benchmark/benchmark.h>

#include <memory>

#include "fsw/vision/image/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct Pair {
  test::Image a = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 2, 1);
  test::Image b = test::render_texture(640, 480, {1.08, 0.12, 1040, 2070}, 0.9, 8, 2, 2);
};

const Pair& pair() {
  static const Pair p;
  return p;
}

OverlapWorkspace& workspace() {
  static const auto w = std::make_unique<OverlapWorkspace>();
  return *w;
}

void overlap(benchmark::State& state) {
  OverlapParams params;
  params.method = state.range(0) == 0 ? OverlapMethod::ncc : OverlapMethod::sad;
  OverlapResult result;
  for (auto _ : state) {
    const Status status = measure_overlap(pair().a.view(), pair().b.view(), params, workspace(), result);
    benchmark::DoNotOptimize(status);
  }
  state.counters["overlap"] = result.overlap;
}
BENCHMARK(overlap)->ArgName("sad")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

void overlap_full_turn(benchmark::State& state) {
  OverlapParams params;
  params.max_rotation_rad = 3.14159265358979;
  OverlapResult result;
  for (auto _ : state) {
    const Status status = measure_overlap(pair().a.view(), pair().b.view(), params, workspace(), result);
    benchmark::DoNotOptimize(status);
  }
}
BENCHMARK(overlap_full_turn)->Unit(benchmark::kMillisecond);

void pyramid(benchmark::State& state) {
  for (auto _ : state) {
    const Status status = workspace().a.build(pair().a.view(), coarse_max_side);
    benchmark::DoNotOptimize(status);
  }
}
BENCHMARK(pyramid)->Unit(benchmark::kMillisecond);

void coarse_search(benchmark::State& state) {
  (void)workspace().a.build(pair().a.view(), coarse_max_side).ok();
  (void)workspace().b.build(pair().b.view(), coarse_max_side).ok();
  const int top = workspace().a.levels() - 1;
  for (auto _ : state) {
    const Status status = search_coarse(workspace().a.level(top), workspace().b.level(top), {}, workspace().coarse,
                                        workspace().candidates);
    benchmark::DoNotOptimize(status);
  }
}
BENCHMARK(coarse_search)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
