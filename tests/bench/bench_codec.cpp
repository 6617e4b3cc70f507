// Time of a product and of its parts, 640x480. `none` is OpenJPEG alone, the bar that the region's cost is read
// against.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/wavelet53.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640;
constexpr std::int32_t height = 480;
constexpr std::size_t pixels = std::size_t{width} * height;
constexpr int levels = 5;

std::vector<std::uint8_t> disc() {
  std::vector<std::uint8_t> mask(pixels);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      mask[static_cast<std::size_t>(y * width + x)] = (x - 290) * (x - 290) + (y - 240) * (y - 240) < 180 * 180;
    }
  }
  return mask;
}

void encode(benchmark::State& state) {
  const test::Image image = test::render_texture(width, height, {2, 0.1, 0, 0}, 1, 0, 1, 4);
  const auto mask = disc();
  const auto workspace = std::make_unique<Jpeg2000Workspace>();
  std::vector<std::uint8_t> file(limits::max_product_bytes);
  Jpeg2000Params params;
  params.region = static_cast<RegionCoding>(state.range(0));
  params.layers = static_cast<int>(state.range(1));
  params.max_bytes = pixels / 16;
  Jpeg2000Product product;
  for (auto _ : state) {
    const Status status =
        encode_jpeg2000(image.view(), {mask.data(), width, height}, params, {}, *workspace, file, product);
    if (!status.ok()) state.SkipWithError(status_name(status.code));
  }
  state.counters["encodings"] = product.encodings;
  state.counters["bytes"] = static_cast<double>(product.bytes);
}
BENCHMARK(encode)->ArgNames({"region", "layers"})->ArgsProduct({{0, 1, 2}, {1, 5}})->Unit(benchmark::kMillisecond);

void wavelet_there_and_back(benchmark::State& state) {
  std::vector<std::int32_t> data(pixels);
  std::vector<std::int32_t> scratch(pixels);
  for (std::size_t i = 0; i < pixels; ++i) data[i] = static_cast<std::int32_t>(i * 2654435761U >> 24U);
  for (auto _ : state) {
    forward_wavelet53({data.data(), width, height}, levels, scratch.data());
    inverse_wavelet53({data.data(), width, height}, levels, scratch.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(wavelet_there_and_back)->Unit(benchmark::kMicrosecond);

void mask_to_coefficients(benchmark::State& state) {
  std::vector<std::uint8_t> scratch(pixels);
  const auto mask = disc();
  auto work = mask;
  for (auto _ : state) {
    work = mask;
    propagate_mask53({work.data(), width, height}, levels, scratch.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(mask_to_coefficients)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ilp
