// Dense matching at flight size: 640x480 with 64 disparities.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "fsw/vision/stereo/stereo_matcher.hpp"
#include "tests/support/strip.hpp"

namespace {

using namespace ilp;

constexpr std::int32_t width = 640;
constexpr std::int32_t height = 480;

struct Pair {
  test::Image left{width, height};
  test::Image right{width, height};
};

const Pair& rendered_pair() {
  static const Pair pair = [] {
    Pair p;
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const auto grey = [](double u, double v) {
          return static_cast<std::uint8_t>(test::fractal_texture(u, v, 3, 5));
        };
        p.left.view().at(x, y) = grey(x, y);
        p.right.view().at(x, y) = grey(x + 30 + 15 * std::sin(y / 60.0), y);
      }
    }
    return p;
  }();
  return pair;
}

void match_vga(benchmark::State& state) {
  const Pair& pair = rendered_pair();
  const auto workspace = std::make_unique<StereoWorkspace>();
  std::vector<std::uint8_t> valid(pair.left.pixels.size(), 1);
  std::vector<float> disparity(valid.size());
  std::vector<float> sigma(valid.size());
  const MaskView mask(valid.data(), width, height);
  const DisparityView result{{disparity.data(), width, height}, {sigma.data(), width, height}};
  const auto disparities = static_cast<std::int32_t>(state.range(0));
  for (auto _ : state) {
    StereoMatcher matcher;
    bool pending = matcher
                       .begin(pair.left.view(), pair.right.view(), mask, mask, {0, disparities - 1}, StereoParams{},
                              *workspace, result)
                       .ok();
    while (pending && matcher.step(32, pending).ok()) {
    }
    benchmark::DoNotOptimize(disparity.data());
  }
  state.counters["mega_disparities_per_s"] = benchmark::Counter(
      1e-6 * width * height * static_cast<double>(disparities), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(match_vga)->Arg(32)->Arg(64)->Arg(128)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
