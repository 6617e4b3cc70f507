// Two-view estimation on 500 made-up matches; the bar is 5 ms a pair (PoseLib takes 2.6 ms at 30 % outliers, 6.8 ms at
// 50 %).
#include <benchmark/benchmark.h>

#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "fsw/vision/twoview/solvers/five_point.hpp"
#include "fsw/vision/twoview/solvers/triangulation.hpp"
#include "tests/unit/vision/twoview/synthetic_scene.hpp"

namespace ilp {
namespace {

TwoViewWorkspace workspace;
InlierMask inliers;

test::Scene scene_for(const benchmark::State& state) {
  test::SceneOptions options;
  options.matches = 500;
  options.noise_px = state.range(0) == 50 ? 1 : 0.5;
  options.outlier_share = static_cast<double>(state.range(0)) / 100;
  options.relief = static_cast<double>(state.range(1)) / 100;
  return test::make_scene(options);
}

RansacParams params_for(const benchmark::State& state) {
  RansacParams params{.threshold_px = state.range(0) == 50 ? 2 : 1};
  return params;
}

/// Arguments: outliers, relief, both in per cent. A new seed each time, because the number of trials depends on luck.
void two_view(benchmark::State& state) {
  const test::Scene scene = scene_for(state);
  RansacParams params = params_for(state);
  TwoViewResult result;
  for (auto _ : state) {
    Status status = estimate_two_view(scene.pairs, scene.camera_a, scene.camera_b, params, workspace, inliers, result);
    benchmark::DoNotOptimize(status);
    ++params.seed;
  }
  state.counters["inliers"] = result.inliers;
}
BENCHMARK(two_view)->Args({30, 25})->Args({50, 25})->Args({30, 0})->Args({50, 0})->Unit(benchmark::kMillisecond);

void fundamental(benchmark::State& state) {
  const test::Scene scene = scene_for(state);
  RansacParams params = params_for(state);
  FundamentalResult result;
  for (auto _ : state) {
    Status status = estimate_fundamental(scene.pairs, params, workspace, inliers, result);
    benchmark::DoNotOptimize(status);
    ++params.seed;
  }
  state.counters["inliers"] = result.inliers;
}
BENCHMARK(fundamental)->Args({30, 25})->Args({50, 25})->Unit(benchmark::kMillisecond);

void homography(benchmark::State& state) {
  const test::Scene scene = scene_for(state);
  RansacParams params = params_for(state);
  params.threshold_px *= 1.4;
  HomographyResult result;
  for (auto _ : state) {
    Status status = estimate_homography(scene.pairs, params, workspace, inliers, result);
    benchmark::DoNotOptimize(status);
    ++params.seed;
  }
  state.counters["inliers"] = result.inliers;
}
BENCHMARK(homography)->Args({30, 0})->Args({50, 0})->Unit(benchmark::kMillisecond);

void five_point_solver(benchmark::State& state) {
  test::SceneOptions options{.matches = 500};
  const test::Scene scene = test::make_scene(options);
  std::size_t first = 0;
  std::size_t solutions = 0;
  for (auto _ : state) {
    Vec3 a[5];
    Vec3 b[5];
    for (std::size_t i = 0; i < 5; ++i) {
      const Vec3& x = scene.points[(first + i) % 500];
      a[i] = x / x.z();
      const Vec3 y = scene.b_from_a * x;
      b[i] = y / y.z();
    }
    Mat3 essentials[max_five_point_solutions];
    solutions += five_point(a, b, essentials);
    first = (first + 5) % 500;
  }
  benchmark::DoNotOptimize(solutions);
}
BENCHMARK(five_point_solver)->Unit(benchmark::kMicrosecond);

void triangulate_two_views(benchmark::State& state) {
  const test::Scene scene = test::make_scene({});
  std::size_t i = 0;
  for (auto _ : state) {
    const Vec3& x = scene.points[i];
    const Vec3 y = scene.b_from_a * x;
    const RayView views[2] = {{x.head<2>() / x.z(), {}}, {y.head<2>() / y.z() + Vec2(1e-3, -1e-3), scene.b_from_a}};
    TriangulatedPoint point;
    Status status = triangulate(views, 2, point);
    benchmark::DoNotOptimize(status);
    benchmark::DoNotOptimize(point);
    i = (i + 1) % scene.points.size();
  }
}
BENCHMARK(triangulate_two_views)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
