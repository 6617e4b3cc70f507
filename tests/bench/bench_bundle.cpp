// Bundle adjustment of one window from 2 px rms to a relative change of 1e-6, the whole and one iteration; structure
// and motion of a whole keyframe, and its longest step.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "fsw/vision/multiview/sequence_workspace.hpp"
#if defined(ILP_HAVE_CERES)
#include "tests/unit/vision/multiview/bundle/ceres_bundle.hpp"
#endif
#include "tests/unit/vision/multiview/bundle/ceres_windows.hpp"
#include "tests/unit/vision/multiview/bundle/dubrovnik_window.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"
#include "tests/unit/vision/multiview/synthetic_strip.hpp"

namespace ilp {
namespace {

BundleAdjuster adjuster;
BundleProblem start;
BundleProblem problem;
/// As in a strip.
constexpr BundleParams params{.robust_px = 0.5};

/// 5 cameras, 2000 points, about 8000 observations.
void make_start(int cameras, int fixed, int points) {
  test::make_window({.cameras = cameras, .fixed = fixed, .points = points, .noise_px = 0.3, .step = 1.2}, start);
  test::disturb(start, 2, 9);
}

void time_ours(benchmark::State& state, const BundleParams& with) {
  BundleResult result;
  double iterations = 0;
  for (auto _ : state) {
    problem = start;
    const Status status = adjuster.run(problem, with, result);
    if (!status.ok()) state.SkipWithError("bundle adjustment failed");
    iterations += result.iterations;
  }
  state.counters["points"] = result.points;
  state.counters["observations"] = result.observations;
  state.counters["iterations"] = result.iterations;
  state.counters["per_iteration"] =
      benchmark::Counter(iterations, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["rms_px"] = result.final_rms_px;
  state.counters["cost"] = result.final_cost;
}

void bundle(benchmark::State& state) {
  make_start(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2)));
  time_ours(state, params);
}

void windows(benchmark::internal::Benchmark* bench) {
  bench->Args({5, 2, 1500})->Args({5, 2, 2000})->Args({5, 0, 2000})->Args({7, 2, 2000})->Args({12, 4, 4000});
  bench->Unit(benchmark::kMillisecond);
}
BENCHMARK(bundle)->Apply(windows);

/// The largest window of a recorded strip as the flight meets it, moved by 2 px; false when the data are absent.
bool make_recorded(const char* folder) {
  const test::RecordedWindows strip(folder);
  if (strip.windows().empty()) return false;
  start = **std::max_element(strip.windows().begin(), strip.windows().end(), [](const auto& a, const auto& b) {
    return a->observations.size() < b->observations.size();
  });
  test::disturb(start, 2, 5);
  return true;
}

void recorded_bundle(benchmark::State& state, const char* folder) {
  if (!make_recorded(folder)) return state.SkipWithError("no data");
  time_ours(state, params);
}
BENCHMARK_CAPTURE(recorded_bundle, caliterra_a, "aerial_caliterra_a")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_bundle, caliterra_climb, "aerial_caliterra_climb")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_bundle, coal_oil_point, "aerial_coal_oil_point")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_bundle, entry, "strecha_entry_p10")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_bundle, fountain, "strecha_fountain_p11")->Unit(benchmark::kMillisecond);

void dubrovnik_bundle(benchmark::State& state, const char* name) {
  if (!test::read_dubrovnik(start, name)) return state.SkipWithError("no data");
  time_ours(state, params);
}
BENCHMARK_CAPTURE(dubrovnik_bundle, five, test::dubrovnik_five)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(dubrovnik_bundle, sixteen, test::dubrovnik_sixteen)->Unit(benchmark::kMillisecond);

#if defined(ILP_HAVE_CERES)
/// Ceres Solver on the same problem with the same loss, start and tolerance: compare with the column CPU of the above.
void time_ceres(benchmark::State& state, const BundleParams& with) {
  test::CeresResult result;
  for (auto _ : state) {
    result = test::adjust_with_ceres(start, with);
    state.SetIterationTime(result.solve_s);
  }
  state.counters["iterations"] = result.iterations;
  state.counters["cost"] = result.final_cost;
}

void ceres_bundle(benchmark::State& state) {
  make_start(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2)));
  time_ceres(state, params);
}
BENCHMARK(ceres_bundle)->Apply(windows)->UseManualTime();

void recorded_ceres(benchmark::State& state, const char* folder) {
  if (!make_recorded(folder)) return state.SkipWithError("no data");
  time_ceres(state, params);
}
BENCHMARK_CAPTURE(recorded_ceres, caliterra_a, "aerial_caliterra_a")->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_ceres, caliterra_climb, "aerial_caliterra_climb")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_ceres, coal_oil_point, "aerial_coal_oil_point")
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_ceres, entry, "strecha_entry_p10")->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(recorded_ceres, fountain, "strecha_fountain_p11")->UseManualTime()->Unit(benchmark::kMillisecond);

void dubrovnik_ceres(benchmark::State& state, const char* name) {
  if (!test::read_dubrovnik(start, name)) return state.SkipWithError("no data");
  time_ceres(state, params);
}
BENCHMARK_CAPTURE(dubrovnik_ceres, five, test::dubrovnik_five)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(dubrovnik_ceres, sixteen, test::dubrovnik_sixteen)->UseManualTime()->Unit(benchmark::kMillisecond);
#endif

SequenceState sequence_state;
SequenceWorkspace sequence_workspace;

/// A whole keyframe of a strip under way, from matches to final poses: the window is full from the sixth on.
void keyframe(benchmark::State& state) {
  const test::SyntheticStrip strip({.keyframes = 12, .corners = static_cast<int>(state.range(0))});
  Sequence sequence(sequence_state, sequence_workspace);
  SequenceReport report;
  SequenceCamera camera;
  FinalPoint point;
  double worst_step = 0;
  for (auto _ : state) {
    state.PauseTiming();
    bool good = sequence.begin_strip(strip.camera, {}).ok();
    for (std::size_t k = 0; good && k < strip.keyframes.size(); ++k) {
      const test::StripKeyframe& frame = strip.keyframes[k];
      const bool last = k + 1 == strip.keyframes.size();
      good = sequence.begin_keyframe(static_cast<std::int64_t>(k), frame.corners, frame.matches, k).ok();
      if (last) state.ResumeTiming();
      while (good && !sequence.idle()) {
        const auto begun = std::chrono::steady_clock::now();
        good = sequence.step().ok();
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begun;
        if (last) worst_step = std::max(worst_step, spent.count());
      }
      if (last) break;
      while (sequence.take_final_camera(camera)) continue;
      while (sequence.take_final_point(point)) continue;
    }
    report = sequence.report();
    if (!good || report.verdict != SequenceVerdict::ok) state.SkipWithError("keyframe failed");
  }
  state.counters["worst_step_ms"] = 1e3 * worst_step;
  state.counters["bundle_points"] = report.bundle_points;
  state.counters["observations"] = report.bundle_observations;
  state.counters["iterations"] = report.bundle_iterations;
}
BENCHMARK(keyframe)->Arg(600)->Arg(1200)->Unit(benchmark::kMillisecond)->Iterations(20);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
