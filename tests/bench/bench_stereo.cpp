// Rectification, dense matching and depth at flight size: 640x480.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>

#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "tests/support/strip.hpp"

#ifdef ILP_HAVE_OPENCV_CALIB3D
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#endif

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

void match_vga(benchmark::State& state, StereoMatcherChoice matcher_choice) {
  const Pair& pair = rendered_pair();
  const auto workspace = std::make_unique<StereoWorkspace>();
  std::vector<std::uint8_t> valid(pair.left.pixels.size(), 1);
  std::vector<float> disparity(valid.size());
  std::vector<float> sigma(valid.size());
  const MaskView mask(valid.data(), width, height);
  const DisparityView result{{disparity.data(), width, height}, {sigma.data(), width, height}};
  const auto disparities = static_cast<std::int32_t>(state.range(0));
  StereoParams params{.matcher = matcher_choice};
  for (auto _ : state) {
    StereoMatcher matcher;
    if (matcher.begin(pair.left.view(), pair.right.view(), mask, mask, {0, disparities - 1}, params, *workspace, result)
            .ok()) {
      static_cast<void>(do_all([&] { return matcher.step(32); }));
    }
    benchmark::DoNotOptimize(disparity.data());
  }
  state.counters["mega_disparities_per_s"] = benchmark::Counter(
      1e-6 * width * height * static_cast<double>(disparities), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(match_vga, semi_global, StereoMatcherChoice::semi_global)
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(match_vga, ordered_scanline, StereoMatcherChoice::ordered_scanline)
    ->Arg(32)
    ->Arg(64)
    ->Arg(128)
    ->Unit(benchmark::kMillisecond);

#ifdef ILP_HAVE_OPENCV_CALIB3D
/// Block 5x5, penalties and filters as its documentation advises; one thread.
void opencv_sgbm_vga(benchmark::State& state) {
  cv::setNumThreads(1);
  const Pair& pair = rendered_pair();
  const auto matrix = [](const test::Image& image) {
    return cv::Mat(height, width, CV_8U, const_cast<std::uint8_t*>(image.pixels.data()));
  };
  const cv::Mat left = matrix(pair.left), right = matrix(pair.right);
  const auto mode = static_cast<int>(state.range(1));
  const auto matcher =
      cv::StereoSGBM::create(0, static_cast<int>(state.range(0)), 5, 200, 800, 1, 63, 10, 100, 2, mode);
  cv::Mat disparity;
  for (auto _ : state) {
    matcher->compute(left, right, disparity);
    benchmark::DoNotOptimize(disparity.data);
  }
}
BENCHMARK(opencv_sgbm_vga)
    ->ArgNames({"disparities", "mode"})
    ->Args({64, cv::StereoSGBM::MODE_SGBM})
    ->Args({64, cv::StereoSGBM::MODE_SGBM_3WAY})
    ->Args({64, cv::StereoSGBM::MODE_HH})
    ->Unit(benchmark::kMillisecond);
#endif

/// A nadir pair with a fifth of the image as baseline.
struct Rectified {
  CameraModel camera;
  RectifiedPair pair;
  DisparityRange range;

  Rectified() {
    camera.width = width;
    camera.height = height;
    camera.fx = camera.fy = 600;
    camera.cx = 320;
    camera.cy = 240;
    camera.k1 = -0.1;
    RigidTransform left;
    RigidTransform right{.translation = Vec3(-20, 1, 0.5)};
    (void)plan_rectification(camera, left, right, {90, 110}, {}, pair, range);
  }
  [[nodiscard]] std::size_t pixels() const { return static_cast<std::size_t>(pair.width * pair.height); }
};

void resample_one_image(benchmark::State& state) {
  const Rectified r;
  std::vector<std::uint8_t> grey(r.pixels());
  std::vector<std::uint8_t> valid(r.pixels());
  for (auto _ : state) {
    (void)resample_rows(r.pair, Side::left, r.camera, rendered_pair().left.view(), 0, r.pair.height,
                        {grey.data(), r.pair.width, r.pair.height}, {valid.data(), r.pair.width, r.pair.height});
    benchmark::DoNotOptimize(grey.data());
  }
}
BENCHMARK(resample_one_image)->Unit(benchmark::kMillisecond);

/// A descent by a tenth of the height, the epipole in the middle: planning, and all panels of one image.
struct PolarPlan {
  Rectified nadir;
  RigidTransform left, right;
  RectificationPlan plan;

  PolarPlan() {
    right.translation = Vec3(0, 0, -10);
    (void)make();
  }
  [[nodiscard]] Status make() { return plan_panels(nadir.camera, left, right, {90, 110}, RectificationParams{}, plan); }
};

void plan_polar_pair(benchmark::State& state) {
  const auto polar = std::make_unique<PolarPlan>();
  for (auto _ : state) {
    (void)polar->make();
    benchmark::DoNotOptimize(polar->plan.count);
  }
}
BENCHMARK(plan_polar_pair)->Unit(benchmark::kMillisecond);

void resample_one_image_in_polar_panels(benchmark::State& state) {
  const auto polar = std::make_unique<PolarPlan>();
  std::vector<std::uint8_t> grey(limits::max_rectified_pixels);
  std::vector<std::uint8_t> valid(limits::max_rectified_pixels);
  double pixels = 0;
  for (auto _ : state) {
    pixels = 0;
    for (std::size_t i = 0; i < polar->plan.count; ++i) {
      const RectifiedPair& pair = polar->plan.panels[i].pair;
      (void)resample_rows(pair, Side::left, polar->nadir.camera, rendered_pair().left.view(), 0, pair.height,
                          {grey.data(), pair.width, pair.height}, {valid.data(), pair.width, pair.height});
      benchmark::DoNotOptimize(grey.data());
      pixels += static_cast<double>(pair.width) * pair.height;
    }
  }
  state.counters["panels"] = static_cast<double>(polar->plan.count);
  state.counters["mega_pixels"] = 1e-6 * pixels;
}
BENCHMARK(resample_one_image_in_polar_panels)->Unit(benchmark::kMillisecond);

void depth_of_one_image(benchmark::State& state) {
  const Rectified r;
  std::vector<float> disparity(r.pixels(), static_cast<float>(r.range.min_px) + 10.3F);
  std::vector<float> sigma(r.pixels(), 0.2F);
  std::vector<DisparityKind> kind(r.pixels(), DisparityKind::measured);
  std::vector<float> inverse_depth(static_cast<std::size_t>(width) * height);
  std::vector<float> depth_sigma(inverse_depth.size());
  std::vector<std::uint64_t> supported(static_cast<std::size_t>(supported_words(width)) * height);
  const DisparityView map{{disparity.data(), r.pair.width, r.pair.height},
                          {sigma.data(), r.pair.width, r.pair.height},
                          {kind.data(), r.pair.width, r.pair.height}};
  for (auto _ : state) {
    (void)depth_rows(r.pair, r.camera, map, 0, height,
                     {{inverse_depth.data(), width, height},
                      {depth_sigma.data(), width, height},
                      {supported.data(), supported_words(width), height}});
    benchmark::DoNotOptimize(inverse_depth.data());
  }
}
BENCHMARK(depth_of_one_image)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
