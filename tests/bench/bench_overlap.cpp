// Overlap of a pair of 640x480 images and its parts; beside OpenCV's matchTemplate and phaseCorrelate on the same
// subsampled images where OpenCV is installed.
#include <benchmark/benchmark.h>

#include <memory>

#include "fsw/base/math.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

#ifdef ILP_HAVE_OPENCV
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#endif

namespace ilp {
namespace {

struct Pair {
  test::Image a = test::render_texture(640, 480, {1, 0, 1000, 2000}, 1, 0, 2, 1);
  test::Image turned = test::render_texture(640, 480, {1.08, 0.12, 1040, 2070}, 0.9, 8, 2, 2);
  test::Image shifted = test::render_texture(640, 480, {1, 0, 1060, 2040}, 0.9, 8, 2, 2);
};

const Pair& pair() {
  static const Pair p;
  return p;
}

OverlapWorkspace& workspace() {
  static const auto w = std::make_unique<OverlapWorkspace>();
  return *w;
}

enum class Search : std::uint8_t { shift, ordinary, full_turn };

OverlapParams params_of(const benchmark::State& state) {
  OverlapParams params{.method = state.range(1) == 0 ? OverlapMethod::ncc : OverlapMethod::sad};
  switch (static_cast<Search>(state.range(0))) {
    case Search::shift:
      params.max_rotation_rad = 0;
      params.max_scale = 1;
      break;
    case Search::ordinary:
      break;
    case Search::full_turn:
      params.max_rotation_rad = pi;
      params.max_scale = 1.4;
      break;
  }
  return params;
}

const test::Image& second_image(const benchmark::State& state) {
  return static_cast<Search>(state.range(0)) == Search::shift ? pair().shifted : pair().turned;
}

// Everything from two images on, subsampling included.
void overlap(benchmark::State& state) {
  const OverlapParams params = params_of(state);
  OverlapResult result;
  for (auto _ : state) {
    Status status = measure_overlap(pair().a.view(), second_image(state).view(), params, workspace(), result);
    benchmark::DoNotOptimize(status);
  }
  state.SetLabel(name_of(result.verdict));
  state.counters["overlap"] = result.overlap;
}

// The same with a keyframe that was prepared before.
void overlap_to_keyframe(benchmark::State& state) {
  static const auto keyframe = std::make_unique<OverlapTemplate>();
  const OverlapParams params = params_of(state);
  if (!prepare_overlap(pair().a.view(), *keyframe, workspace()).ok()) state.SkipWithError("no keyframe");
  OverlapResult result;
  for (auto _ : state) {
    Status status = measure_overlap(*keyframe, second_image(state).view(), params, workspace(), result);
    benchmark::DoNotOptimize(status);
  }
  state.SetLabel(name_of(result.verdict));
}

void searches(benchmark::internal::Benchmark* b) {
  b->ArgNames({"search", "sad"})->ArgsProduct({{0, 1, 2}, {0, 1}})->Unit(benchmark::kMillisecond);
}
BENCHMARK(overlap)->Apply(searches);
BENCHMARK(overlap_to_keyframe)->Apply(searches);

void pyramid(benchmark::State& state) {
  for (auto _ : state) {
    Status status = workspace().b.build(pair().a.view(), coarse_max_side);
    benchmark::DoNotOptimize(status);
  }
}
BENCHMARK(pyramid)->Unit(benchmark::kMillisecond);

#ifdef ILP_HAVE_OPENCV
cv::Mat matrix(const test::Image& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

// Box averages, as the pyramid takes them.
void subsample(const cv::Mat& image, int times, cv::Mat& out) {
  cv::resize(image, out, cv::Size(image.cols / times, image.rows / times), 0, 0, cv::INTER_AREA);
}

void opencv_match_template(benchmark::State& state) {
  cv::setNumThreads(1);
  const int times = static_cast<int>(state.range(0));
  const bool subsampling = state.range(1) != 0;
  const cv::Mat full_a = matrix(pair().a), full_b = matrix(pair().shifted);
  cv::Mat a, b, score;
  subsample(full_a, times, a);
  subsample(full_b, times, b);
  for (auto _ : state) {
    if (subsampling) {
      subsample(full_a, times, a);
      subsample(full_b, times, b);
    }
    const cv::Mat centre = a(cv::Rect(a.cols / 4, a.rows / 4, a.cols / 2, a.rows / 2));
    cv::matchTemplate(b, centre, score, cv::TM_CCOEFF_NORMED);
    cv::Point best;
    cv::minMaxLoc(score, nullptr, nullptr, nullptr, &best);
    benchmark::DoNotOptimize(best);
  }
}
BENCHMARK(opencv_match_template)
    ->ArgNames({"subsampled", "included"})
    ->ArgsProduct({{2, 4, 8}, {0, 1}})
    ->Unit(benchmark::kMillisecond);

void opencv_phase_correlate(benchmark::State& state) {
  cv::setNumThreads(1);
  const int times = static_cast<int>(state.range(0));
  const cv::Mat full_a = matrix(pair().a), full_b = matrix(pair().shifted);
  cv::Mat a, b, float_a, float_b, window;
  cv::createHanningWindow(window, cv::Size(640 / times, 480 / times), CV_32F);
  for (auto _ : state) {
    subsample(full_a, times, a);
    subsample(full_b, times, b);
    a.convertTo(float_a, CV_32F);
    b.convertTo(float_b, CV_32F);
    cv::Point2d shift = cv::phaseCorrelate(float_a, float_b, window);
    benchmark::DoNotOptimize(shift);
  }
}
BENCHMARK(opencv_phase_correlate)->ArgName("subsampled")->Arg(2)->Arg(4)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
