// Time to join a flight that comes back to its own ground: lanes of 50 keyframes beside each other, each keyframe
// linked to two of the lane before, poses that drift; everything at once, and after one more keyframe.
#include <benchmark/benchmark.h>

#include <ctime>
#include <utility>

#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

test::NoisyFlight flight_of(std::int64_t keyframes) {
  constexpr int per_lane = 50;
  test::NoisyFlight flight;
  flight.fly_lanes(static_cast<int>(keyframes) / per_lane, per_lane);
  flight.drift_in_scale();
  return flight;
}

/// Processor time, s.
double join(intake::Flight& flight, intake::ResultCache* results, JoinedFlight& joined) {
  const std::clock_t begin = std::clock();
  joined = join_strips(
      flight, [](const std::string&) {}, results);
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

void join_lanes(benchmark::State& state) {
  const test::NoisyFlight flight = flight_of(state.range(0));
  JoinedFlight joined;
  intake::Flight result;
  for (auto _ : state) {
    state.PauseTiming();
    result = flight.flight_;
    state.ResumeTiming();
    (void)join(result, nullptr, joined);
  }
  if (joined.models.size() != 1) return state.SkipWithError("not one model");
  const auto keyframes = static_cast<double>(state.range(0));
  state.counters["links"] = static_cast<double>(joined.models[0].links.size());
  state.counters["sightings"] = static_cast<double>(joined.models[0].sightings);
  state.counters["error_px"] = joined.models[0].median_error_px;
  state.counters["error_of_height"] = flight.rms_error(result);
  state.counters["per_keyframe"] =
      benchmark::Counter(keyframes, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(join_lanes)->Arg(250)->Arg(500)->Arg(1000)->Arg(2000)->Arg(4000)->Unit(benchmark::kSecond)->Iterations(1);

/// Lanes of 25 keyframes, each a strip of its own.
void join_many_strips(benchmark::State& state) {
  test::NoisyFlight flight;
  flight.fly_strips(static_cast<int>(state.range(0)) / 25, 25);
  JoinedFlight joined;
  for (auto _ : state) (void)join(flight.flight_, nullptr, joined);
  if (joined.models.size() != 1) return state.SkipWithError("not one model");
  state.counters["error_of_height"] = flight.rms_error(flight.flight_);
  state.counters["per_keyframe"] = benchmark::Counter(
      static_cast<double>(state.range(0)), benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}
BENCHMARK(join_many_strips)->Arg(250)->Arg(500)->Arg(1000)->Arg(2000)->Unit(benchmark::kSecond)->Iterations(1);

/// With the results kept of the run before the last keyframe came.
void one_more_keyframe(benchmark::State& state) {
  const test::NoisyFlight flight = flight_of(state.range(0));
  JoinedFlight joined;
  double first = 0, then = 0;
  for (auto _ : state) {
    state.PauseTiming();
    intake::MemoryResultCache results;
    intake::Flight before = flight.without_last(), after = flight.flight_;
    first = join(before, &results, joined);
    const std::size_t kept = results.size();
    state.ResumeTiming();
    then = join(after, &results, joined);
    state.counters["adjusted_first"] = static_cast<double>(kept);
    state.counters["adjusted_again"] = static_cast<double>(results.size() - kept);
  }
  state.counters["share_of_first_run"] = then / first;
}
BENCHMARK(one_more_keyframe)->Arg(500)->Arg(1000)->Arg(2000)->Unit(benchmark::kSecond)->Iterations(1);

}  // namespace
}  // namespace ilp::model

BENCHMARK_MAIN();
