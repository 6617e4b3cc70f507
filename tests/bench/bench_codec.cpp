// Time of a product and of its parts, 640x480. `opj_encode` is OpenJPEG alone on the same image, with the same bytes
// and layers: the bar that the region's cost is read against.
#include <benchmark/benchmark.h>

#include <memory>
#include <vector>

#include "fsw/vision/codec/background_fill.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"
#include "fsw/vision/codec/layer_errors.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"
#include "fsw/vision/codec/wavelet53.hpp"
#include "fsw/vision/terrain/mask_coding.hpp"
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

test::Image scene() {
  return test::render_texture(width, height, {2, 0.1, 0, 0}, 1, 0, 1, 4);
}

/// The ceiling that the argument gives in hundredths of a bit per pixel.
std::size_t ceiling_of(const benchmark::State& state) {
  return pixels * static_cast<std::size_t>(state.range(1)) / 800;
}

void opj_encode(benchmark::State& state) {
  const test::Image image = scene();
  std::vector<std::int32_t> samples(pixels);
  for (std::size_t i = 0; i < pixels; ++i) samples[i] = image.pixels[i] - 128;
  std::vector<std::uint8_t> codestream(limits::max_product_bytes);
  std::vector<double> targets(static_cast<std::size_t>(state.range(0)));
  auto size = static_cast<double>(ceiling_of(state));
  for (std::size_t i = targets.size(); i-- > 0; size /= 2) targets[i] = size;
  CodestreamParams params{.packet_lengths = targets.size() > 1, .layer_bytes = targets};
  std::size_t bytes = 0;
  for (auto _ : state) {
    const Status status = openjpeg_encode({samples.data(), width, height}, params, codestream, bytes);
    if (!status.ok()) state.SkipWithError(status_name(status.code));
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}

void encode(benchmark::State& state, RegionCoding region) {
  const test::Image image = scene();
  const auto mask = disc();
  const auto workspace = std::make_unique<Jpeg2000Workspace>();
  std::vector<std::uint8_t> file(limits::max_product_bytes);
  Jpeg2000Params params;
  params.region = region;
  params.layers = static_cast<int>(state.range(0));
  params.max_bytes = ceiling_of(state);
  Jpeg2000Product product;
  for (auto _ : state) {
    const Status status =
        encode_jpeg2000(image.view(), {mask.data(), width, height}, params, {}, *workspace, file, product);
    if (!status.ok()) state.SkipWithError(status_name(status.code));
  }
  state.counters["encodings"] = product.encodings;
  state.counters["bytes"] = static_cast<double>(product.bytes);
}

void shifted_background(benchmark::State& state) {
  encode(state, RegionCoding::shift);
}
void dropped_background(benchmark::State& state) {
  encode(state, RegionCoding::drop_background);
}

void arguments(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"layers", "bpp_100"})->ArgsProduct({{1, 4}, {25, 50, 100, 200, 400}})->Unit(benchmark::kMillisecond);
}
BENCHMARK(opj_encode)->Apply(arguments);
BENCHMARK(shifted_background)->Apply(arguments);
BENCHMARK(dropped_background)->Apply(arguments);

void layers_measured(benchmark::State& state) {
  const test::Image image = scene();
  const auto mask = disc();
  const auto workspace = std::make_unique<Jpeg2000Workspace>();
  std::vector<std::uint8_t> file(limits::max_product_bytes);
  Jpeg2000Params params;
  params.layers = static_cast<int>(state.range(0));
  params.max_bytes = ceiling_of(state);
  Jpeg2000Product product;
  const MaskView region(mask.data(), width, height);
  if (!encode_jpeg2000(image.view(), region, params, {}, *workspace, file, product).ok()) {
    state.SkipWithError("encoding");
  }
  LayerErrors errors;
  for (auto _ : state) {
    const Status status = measure_layer_errors(std::span(file).first(product.bytes), image.view(), region, errors);
    if (!status.ok()) state.SkipWithError(status_name(status.code));
  }
}
BENCHMARK(layers_measured)->Apply(arguments);

void wavelet(benchmark::State& state) {
  std::vector<std::int32_t> data(pixels);
  std::vector<std::int32_t> scratch(pixels);
  for (std::size_t i = 0; i < pixels; ++i) data[i] = static_cast<std::int32_t>(i * 2654435761U >> 24U);
  for (auto _ : state) {
    forward_wavelet53({data.data(), width, height}, levels, scratch.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(wavelet)->Unit(benchmark::kMicrosecond);

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

void background_filled(benchmark::State& state) {
  const auto mask = disc();
  std::vector<std::int32_t> samples(pixels), scratch(limits::max_image_pixels);
  for (std::size_t i = 0; i < pixels; ++i) samples[i] = static_cast<std::int32_t>(i % 4096);
  for (auto _ : state) {
    fill_background({samples.data(), width, height}, {mask.data(), width, height}, scratch.data());
    benchmark::ClobberMemory();
  }
}
BENCHMARK(background_filled)->Unit(benchmark::kMicrosecond);

void mask_coded(benchmark::State& state) {
  const auto mask = disc();
  std::vector<std::uint8_t> bytes(max_mask_bytes(pixels));
  std::size_t size = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(encode_mask({mask.data(), width, height}, bytes.data(), bytes.size(), size));
  }
  state.counters["bytes"] = static_cast<double>(size);
}
BENCHMARK(mask_coded)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace ilp
