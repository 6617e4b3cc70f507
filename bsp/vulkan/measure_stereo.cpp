#include <algorithm>
#include <cstdio>
#include <cstring>

#include "bsp/vulkan/measure.hpp"
#include "bsp/vulkan/stopwatch.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"

namespace ilp {
namespace {

constexpr std::int32_t width = 640, height = 480, disparities = 64, shift = 29;

template <typename T>
using Image = FixedImage<T, std::size_t{width} * height>;
Image<std::uint8_t> left, right, valid;
Image<float> disparity, sigma;
StereoWorkspace matching, processor;
StereoBandWorkspace borrowed;
StereoBandJob job;
StereoBandOutput by_processor;

bool make_pair() {
  if (!left.resize(width, height).ok() || !right.resize(width, height).ok() || !valid.resize(width, height).ok() ||
      !disparity.resize(width, height).ok() || !sigma.resize(width, height).ok()) {
    return false;
  }
  Rng noise(7);
  const auto ground = [](std::int32_t x, std::int32_t y) {
    return mix64(static_cast<std::uint64_t>(y / 2) * 4096 + static_cast<std::uint64_t>(x / 2)) & 0xFFU;
  };
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      left.view().at(x, y) = static_cast<std::uint8_t>(ground(x, y));
      right.view().at(x, y) = static_cast<std::uint8_t>(ground(x + shift, y) ^ noise.below(4));
      valid.view().at(x, y) = 255;
    }
  }
  return true;
}

}  // namespace

bool measure_stereo_pair(StereoBandDeviceJob& bands) {
  StereoMatcher matcher;
  StereoMatcher::lend(processor, borrowed);
  if (!make_pair()) return false;
  bool pending = matcher
                     .begin(left.view(), right.view(), valid.view(), valid.view(), {0, disparities - 1}, {}, matching,
                            {disparity.view(), sigma.view()})
                     .ok() &&
                 matcher.match_in_bands(job);
  double device_s = 0, processor_s = 0;
  int jobs = 0;
  while (pending) {
    if (matcher.wants_band()) {
      matcher.describe_band();
      const Stopwatch of_device;
      if (!bands.run(memory_of(job.input), std::as_writable_bytes(std::span(&job.output, 1)))) return false;
      device_s += of_device.seconds();
      const Stopwatch of_processor;
      for (std::size_t unit = 0; unit < stereo_band_units; ++unit) {
        compute_stereo_band_unit(job.input, unit, borrowed,
                                 std::as_writable_bytes(std::span(&by_processor, 1))
                                     .subspan(unit * stereo_band_unit_bytes, stereo_band_unit_bytes));
      }
      processor_s += of_processor.seconds();
      if (std::memcmp(&job.output, &by_processor, sizeof(by_processor)) != 0) {
        std::printf("band %d: the bytes of the device are not those of the processor\n", jobs);
        return false;
      }
      matcher.take_band();
      ++jobs;
    }
    pending = matcher.step(stereo_band_rows).value();
  }
  std::printf("a pair of %d x %d px in %d jobs, %zu bytes in and %zu bytes out per job\n", width, height, jobs,
              sizeof(StereoBandInput), sizeof(StereoBandOutput));
  std::printf("device %.3f s, processor %.3f s, all bytes equal\n", device_s, processor_s);
  return jobs > 0;
}

}  // namespace ilp
