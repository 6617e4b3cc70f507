// Time to join a flight that comes back to its own ground: lanes of 50 keyframes beside each other, each keyframe
// linked to two of the lane before, poses that drift.
#include <benchmark/benchmark.h>

#include <cmath>

#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

void join_lanes(benchmark::State& state) {
  constexpr int per_lane = 50;
  test::NoisyFlight flight;
  flight.fly_lanes(static_cast<int>(state.range(0)) / per_lane, per_lane);
  flight.drift([](std::int64_t id) {
    return Similarity{Mat3::Identity(), Vec3::Zero(), 1 + 0.002 * std::sin(0.065 * static_cast<double>(id))};
  });
  JoinedFlight joined;
  for (auto _ : state) {
    state.PauseTiming();
    intake::Flight copy = flight.flight_;
    state.ResumeTiming();
    joined = join_strips(copy, [](const std::string&) {});
  }
  if (joined.models.size() != 1) return state.SkipWithError("not one model");
  const auto keyframes = static_cast<double>(state.range(0));
  state.counters["links"] = static_cast<double>(joined.models[0].links.size());
  state.counters["sightings"] = static_cast<double>(joined.models[0].sightings);
  state.counters["error_px"] = joined.models[0].median_error_px;
  state.counters["per_keyframe"] =
      benchmark::Counter(keyframes, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(join_lanes)->Arg(250)->Arg(500)->Arg(1000)->Arg(2000)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace ilp::model

BENCHMARK_MAIN();
