// Harris corners and their matches, 640x480.
#include <benchmark/benchmark.h>

#include <memory>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct Pair {
  Similarity2 world_from_a{1, 0, 1000, 2000}, world_from_b{1.08, 0.12, 1040, 2070};
  test::Image a = test::render_texture(640, 480, world_from_a, 1, 0, 1, 1);
  test::Image b = test::render_texture(640, 480, world_from_b, 0.9, 8, 1, 2);
  Similarity2 b_from_a = test::compose(test::inverse(world_from_b), world_from_a);
};

const Pair& pair() {
  static const Pair p;
  return p;
}

Status detect(GrayView image, std::int64_t count, Corners& corners) {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  HarrisParams params;
  params.target_count = static_cast<std::int32_t>(count);
  return detect_corners(image, params, *workspace, corners);
}

void harris(benchmark::State& state) {
  Corners corners;
  for (auto _ : state) {
    const Status status = detect(pair().a.view(), state.range(0), corners);
    benchmark::DoNotOptimize(status);
  }
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(harris)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

void match(benchmark::State& state) {
  static const auto workspace = std::make_unique<MatcherWorkspace>();
  Corners corners_a, corners_b;
  (void)detect(pair().a.view(), state.range(0), corners_a).ok();
  (void)detect(pair().b.view(), state.range(0), corners_b).ok();
  Matches matches;
  for (auto _ : state) {
    const Status status =
        match_corners(pair().a.view(), corners_a, pair().b.view(), corners_b, pair().b_from_a, {}, *workspace, matches);
    benchmark::DoNotOptimize(status);
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(match)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

void match_and_track(benchmark::State& state) {
  static const auto workspace = std::make_unique<MatcherWorkspace>();
  Corners corners_a, corners_b, longer_b;
  (void)detect(pair().a.view(), state.range(0), corners_a).ok();
  (void)detect(pair().b.view(), state.range(0), corners_b).ok();
  const Similarity2& s = pair().b_from_a;
  const double re = s.scale * det_cos(s.rotation_rad), im = s.scale * det_sin(s.rotation_rad);
  const double plane[9] = {re, -im, s.shift_x_px, im, re, s.shift_y_px, 0, 0, 1};
  Matches matches;
  for (auto _ : state) {
    longer_b = corners_b;
    const Status status =
        match_and_track_corners(pair().a.view(), corners_a, pair().b.view(), longer_b, plane, {}, *workspace, matches);
    benchmark::DoNotOptimize(status);
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(match_and_track)->Arg(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
