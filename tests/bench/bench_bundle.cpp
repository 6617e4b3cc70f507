// Bundle adjustment of one window from 2 px rms to a relative change of 1e-6: time of the whole and of one iteration.
// With Ceres installed, its DENSE_SCHUR solver runs on the same problem beside it.
#include <benchmark/benchmark.h>

#include "fsw/vision/multiview/bundle_adjustment.hpp"
#include "tests/unit/vision/multiview/synthetic_window.hpp"

namespace ilp {
namespace {

BundleAdjuster adjuster;
BundleProblem start;
BundleProblem problem;

/// 5 cameras, 2000 points, about 8000 observations.
void make_start(int cameras, int fixed, int points) {
  test::make_window({.cameras = cameras, .fixed = fixed, .points = points, .noise_px = 0.3, .step = 1.2}, start);
  test::disturb(start, 2, 9);
}

void bundle(benchmark::State& state) {
  make_start(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2)));
  BundleResult result;
  double iterations = 0;
  for (auto _ : state) {
    problem = start;
    const Status status = adjuster.run(problem, {}, result);
    if (!status.ok()) state.SkipWithError("bundle adjustment failed");
    iterations += result.iterations;
  }
  state.counters["observations"] = result.observations;
  state.counters["iterations"] = result.iterations;
  state.counters["per_iteration"] =
      benchmark::Counter(iterations, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["rms_px"] = result.final_rms_px;
}
BENCHMARK(bundle)
    ->Args({5, 2, 1500})
    ->Args({5, 2, 2000})
    ->Args({5, 0, 2000})
    ->Args({7, 2, 2000})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
