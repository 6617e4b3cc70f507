// Time of the richness index of a keyframe: the whole image new, and a strip of 18 %.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "fsw/vision/terrain/richness.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

void score(benchmark::State& state) {
  constexpr std::int32_t width = 640;
  constexpr std::int32_t height = 480;
  const test::Image image = test::render_texture(width, height, {2, 0.1, 0, 0}, 1, 0, 1, 4);
  CameraModel camera{width, height, 550, 550, 319.5, 239.5};
  std::vector<std::uint8_t> mask(image.pixels.size());
  std::vector<float> inverse(image.pixels.size());
  const std::vector<float> sigma(image.pixels.size(), 1e-5F);
  const auto first = static_cast<std::int32_t>(width * (100 - state.range(0)) / 100);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      mask[i] = x >= first ? 255 : 0;
      inverse[i] = 0.01F + 1e-6F * static_cast<float>(image.pixels[i]);
    }
  }
  const auto workspace = std::make_unique<RichnessWorkspace>();
  RichnessCues cues;
  double index = 0;
  for (auto _ : state) {
    const Status status =
        score_richness(camera, image.view(), {inverse.data(), width, height}, {sigma.data(), width, height},
                       {mask.data(), width, height}, RichnessParams{}, RichnessHistory{}, *workspace, cues, index);
    if (!status.ok()) state.SkipWithError("score_richness");
    benchmark::DoNotOptimize(index);
  }
}
BENCHMARK(score)->ArgName("newly seen %")->Arg(100)->Arg(18)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
