// The chain from image to product as ratios: the processor time of each part over that of OpenCV's StereoSGBM (640x480,
// 64 disparities, one thread) in the same run. A part and its reference take turns, so that other work on the machine
// disturbs both. `of_sgbm` is the ratio of the medians. Parts of the flight are per keyframe: they come from one flight
// of the default scenario in memory.
#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <memory>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "fsw/base/math.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "tests/bench/chain_flight.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/vision/multiview/bundle/synthetic_window.hpp"

namespace ilp::bench {
namespace {

constexpr int flight_frames = 40;
constexpr int rounds = 21;
constexpr std::int32_t disparities = 64;

struct Pair {
  test::Image left, right;

  Pair(std::int32_t width, std::int32_t height) : left(width, height), right(width, height) {
    const auto grey = [](double u, double v) { return static_cast<std::uint8_t>(test::fractal_texture(u, v, 3, 5)); };
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        left.view().at(x, y) = grey(x, y);
        right.view().at(x, y) = grey(x + 30 + 15 * std::sin(y / 60.0), y);
      }
    }
  }
};

/// Block 5x5, penalties and filters as its documentation advises.
class Sgbm final : public Reference {
 public:
  explicit Sgbm(const Pair& pair) : left_(matrix(pair.left)), right_(matrix(pair.right)) { cv::setNumThreads(1); }

  double run() override {
    const double begun = processor_ms();
    matcher_->compute(left_, right_, disparity_);
    return processor_ms() - begun;
  }

 private:
  static cv::Mat matrix(const test::Image& image) {
    return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data())};
  }

  cv::Ptr<cv::StereoSGBM> matcher_ =
      cv::StereoSGBM::create(0, disparities, 5, 200, 800, 1, 63, 10, 100, 2, cv::StereoSGBM::MODE_SGBM);
  cv::Mat left_, right_, disparity_;
};

const Pair& pair_of(std::int32_t width) {
  static const Pair small(320, 240), usual(640, 480), large(1024, 1024);
  return width == 320 ? small : width == 640 ? usual : large;
}

Sgbm& usual_sgbm() {
  static Sgbm sgbm(pair_of(640));
  return sgbm;
}

/// Times `part` and the reference in turn.
void compare(benchmark::State& state, Reference& reference, const std::function<void()>& part) {
  std::vector<double> ours, theirs;
  for (auto _ : state) {
    theirs.push_back(reference.run());
    const double begun = processor_ms();
    part();
    ours.push_back(processor_ms() - begun);
    state.SetIterationTime(1e-3 * ours.back());
  }
  state.counters["median_ms"] = median(ours);
  state.counters["of_sgbm"] = median(ours) / median(theirs);
}

void matcher(benchmark::State& state, StereoMatcherChoice choice, VectorWidth vectors) {
  use_vectors(vectors);
  const Pair& pair = pair_of(static_cast<std::int32_t>(state.range(0)));
  const std::int32_t width = pair.left.width, height = pair.left.height;
  const auto workspace = std::make_unique<StereoWorkspace>();
  std::vector<std::uint8_t> valid(pair.left.pixels.size(), 1);
  std::vector<float> disparity(valid.size()), sigma(valid.size());
  const MaskView mask(valid.data(), width, height);
  const DisparityView result{{disparity.data(), width, height}, {sigma.data(), width, height}};
  StereoParams params{.matcher = choice};
  Sgbm sgbm(pair);
  compare(state, sgbm, [&] {
    StereoMatcher stereo;
    if (stereo.begin(pair.left.view(), pair.right.view(), mask, mask, {0, disparities - 1}, params, *workspace, result)
            .ok()) {
      static_cast<void>(do_all([&] { return stereo.step(16); }));
    }
    benchmark::DoNotOptimize(disparity.data());
  });
  use_vectors(widest_vectors());
}
void sizes(benchmark::internal::Benchmark* b) {
  b->ArgName("width")->Arg(320)->Arg(640)->Arg(1024)->UseManualTime()->Iterations(rounds)->Unit(
      benchmark::kMillisecond);
}
// OpenCV's matcher has the same size here.
BENCHMARK_CAPTURE(matcher, semi_global, StereoMatcherChoice::semi_global, widest_vectors())->Apply(sizes);
BENCHMARK_CAPTURE(matcher, semi_global_16_bytes, StereoMatcherChoice::semi_global, VectorWidth::bytes16)->Apply(sizes);
BENCHMARK_CAPTURE(matcher, ordered_scanline, StereoMatcherChoice::ordered_scanline, widest_vectors())->Apply(sizes);

void overlap_to_keyframe(benchmark::State& state, bool full_circle) {
  const test::Image image = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 2, 1);
  const test::Image turned = test::render_texture(640, 480, {1.08, 0.12, 1040, 2070}, 0.9, 8, 2, 2);
  const auto workspace = std::make_unique<OverlapWorkspace>();
  const auto keyframe = std::make_unique<OverlapTemplate>();
  OverlapParams params;
  if (full_circle) {
    params.max_rotation_rad = pi;
    params.max_scale = 1.4;
  }
  if (!prepare_overlap(image.view(), *keyframe, *workspace).ok()) return state.SkipWithError("no keyframe");
  OverlapResult result;
  compare(state, usual_sgbm(), [&] {
    Status status = measure_overlap(*keyframe, turned.view(), params, *workspace, result);
    benchmark::DoNotOptimize(status);
  });
  state.SetLabel(name_of(result.verdict));
}
BENCHMARK_CAPTURE(overlap_to_keyframe, usual, false)
    ->UseManualTime()
    ->Iterations(rounds)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(overlap_to_keyframe, full_circle_and_scale, true)
    ->UseManualTime()
    ->Iterations(rounds)
    ->Unit(benchmark::kMillisecond);

void bundle_5x1500(benchmark::State& state) {
  const auto adjuster = std::make_unique<BundleAdjuster>();
  const auto start = std::make_unique<BundleProblem>();
  const auto problem = std::make_unique<BundleProblem>();
  test::make_window({.cameras = 5, .fixed = 2, .points = 1500, .noise_px = 0.3, .step = 1.2}, *start);
  test::disturb(*start, 2, 9);
  BundleResult result;
  compare(state, usual_sgbm(), [&] {
    *problem = *start;
    if (!adjuster->run(*problem, {.robust_px = 1}, result).ok()) state.SkipWithError("bundle adjustment failed");
  });
}
BENCHMARK(bundle_5x1500)->UseManualTime()->Iterations(rounds)->Unit(benchmark::kMillisecond);

const ChainTimes& flight() {
  static const ChainTimes times = fly_chain(flight_frames, usual_sgbm());
  return times;
}

/// One part of the flight, or the sum of several.
void per_keyframe(benchmark::State& state, const std::vector<std::string>& names) {
  const ChainTimes& times = flight();
  double ms = 0;
  for (const std::string& name : names) ms += times.of(name);
  for (auto _ : state) state.SetIterationTime(1e-3 * ms);
  state.counters["median_ms"] = ms;
  state.counters["of_sgbm"] = ms / times.reference_ms;
}
void all_per_keyframe(benchmark::State& state) {
  const ChainTimes& times = flight();
  for (auto _ : state) state.SetIterationTime(1e-3 * times.all_ms);
  state.counters["median_ms"] = times.all_ms;
  state.counters["of_sgbm"] = times.all_ms / times.reference_ms;
  state.counters["keyframes"] = times.keyframes;
  state.counters["frames"] = times.frames;
}

void register_part(const std::string& name, const std::vector<std::string>& parts) {
  benchmark::RegisterBenchmark(("per_keyframe/" + name).c_str(),
                               [parts](benchmark::State& state) { per_keyframe(state, parts); })
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
}

void register_flight() {
  benchmark::RegisterBenchmark("per_keyframe/all", all_per_keyframe)
      ->UseManualTime()
      ->Iterations(1)
      ->Unit(benchmark::kMillisecond);
  register_part("dense_matching", {"dense_matcher/match"});
  register_part("resampling_depth_masks_sigmas",
                {"dense_matcher/idle", "dense_matcher/resample", "dense_matcher/depth", "dense_matcher/errors",
                 "dense_matcher/mask", "dense_matcher/record"});
  register_part("of_these_resampling", {"dense_matcher/resample"});
  register_part("of_these_depth", {"dense_matcher/depth"});
  register_part("of_these_masks_and_record", {"dense_matcher/errors", "dense_matcher/mask", "dense_matcher/record"});
  register_part("compressor", {"compressor"});
  register_part("check_of_a_known_camera", {"camera_calibrator"});
  register_part("structure_and_motion", {"structure_and_motion"});
  register_part("everything_else",
                {"telecommander", "capture_clock", "acquisition", "overlap_checker", "richness_scorer",
                 "storage_manager", "downlink", "file_delivery", "telecommand_guard", "telemetry", "scrubber",
                 "navigator", "place_memory", "executive"});
  for (const char* const part : {"acquisition", "overlap_checker", "place_memory", "richness_scorer", "storage_manager",
                                 "downlink", "executive"}) {
    register_part(std::string("of_these_") + part, {part});
  }
}

}  // namespace
}  // namespace ilp::bench

int main(int argc, char** argv) {
  ilp::bench::register_flight();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
