// Harris corners and their matches, 640x480; beside OpenCV's goodFeaturesToTrack (Harris) and cornerSubPix, in time and
// in repeatability, where OpenCV is installed.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "tests/support/strip.hpp"

#ifdef ILP_HAVE_OPENCV
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#endif

namespace ilp {
namespace {

struct Pair {
  Similarity2 world_from_a{1, 0, 1000, 2000}, world_from_b{1.08, 0.12, 1040, 2070};
  test::Image a = test::render_texture(640, 480, world_from_a, 1, 0, 1, 1);
  test::Image b = test::render_texture(640, 480, world_from_b, 0.9, 8, 1, 2);
  Similarity2 b_from_a = test::compose(test::inverse(world_from_b), world_from_a);
};

const Pair& pair() {
  static const Pair p;
  return p;
}

Status detect(GrayView image, std::int64_t count, Corners& corners) {
  static const auto workspace = std::make_unique<HarrisWorkspace>();
  HarrisParams params{.target_count = static_cast<std::int32_t>(count)};
  return detect_corners(image, params, *workspace, corners);
}

void harris(benchmark::State& state) {
  Corners corners;
  for (auto _ : state) {
    Status status = detect(pair().a.view(), state.range(0), corners);
    benchmark::DoNotOptimize(status);
  }
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(harris)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

void match(benchmark::State& state) {
  static const auto workspace = std::make_unique<MatcherWorkspace>();
  Corners corners_a, corners_b;
  (void)detect(pair().a.view(), state.range(0), corners_a).ok();
  (void)detect(pair().b.view(), state.range(0), corners_b).ok();
  Matches matches;
  for (auto _ : state) {
    Status status =
        match_corners(pair().a.view(), corners_a, pair().b.view(), corners_b, pair().b_from_a, {}, *workspace, matches);
    benchmark::DoNotOptimize(status);
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(match)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

/// What matching by the plane starts from.
struct PlaneMatching {
  Corners corners_a, corners_b;
  double plane[9];  ///< the similarity between the images as a homography, row-major

  explicit PlaneMatching(const benchmark::State& state) {
    (void)detect(pair().a.view(), state.range(0), corners_a).ok();
    (void)detect(pair().b.view(), state.range(0), corners_b).ok();
    const Similarity2& s = pair().b_from_a;
    const double re = s.scale * det_cos(s.rotation_rad), im = s.scale * det_sin(s.rotation_rad);
    const double homography[9] = {re, -im, s.shift_x_px, im, re, s.shift_y_px, 0, 0, 1};
    std::copy_n(homography, 9, plane);
  }
};

void match_and_track(benchmark::State& state) {
  static const auto workspace = std::make_unique<MatcherWorkspace>();
  const PlaneMatching start(state);
  Corners longer_b;
  Matches matches;
  for (auto _ : state) {
    longer_b = start.corners_b;
    Status status = match_and_track_corners(pair().a.view(), start.corners_a, pair().b.view(), longer_b, start.plane,
                                            {}, *workspace, matches);
    benchmark::DoNotOptimize(status);
  }
  state.counters["matches"] = static_cast<double>(matches.size());
}
BENCHMARK(match_and_track)->Arg(1000)->Unit(benchmark::kMillisecond);

using Points = std::vector<std::pair<double, double>>;

enum Detector : std::uint8_t { ours, opencv, opencv_sub_pixel };

Points detected(const test::Image& image, Detector detector) {
  Points points;
  if (detector == ours) {
    Corners corners;
    (void)detect(image.view(), 1000, corners).ok();
    for (const Corner& c : corners) points.emplace_back(c.x, c.y);
  }
#ifdef ILP_HAVE_OPENCV
  if (detector != ours) {
    const cv::Mat grey(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data()));
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(grey, corners, 1000, 1e-6, 5, cv::noArray(), 5, true, 0.04);
    if (detector == opencv_sub_pixel) {
      cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01});
    }
    for (const cv::Point2f& c : corners) points.emplace_back(c.x, c.y);
  }
#endif
  return points;
}

struct View {
  const char* name;
  double scale, rotation_rad, gain;
};
constexpr View views[] = {
    {"shifted", 1, 0, 1},       {"turned 30 degrees", 1, 0.5236, 1}, {"turned 90 degrees", 1, 1.5708, 1},
    {"scale 0.8", 0.8, 0.1, 1}, {"scale 1.25", 1.25, 0.1, 1},        {"exposure doubled", 1, 0.1, 2}};

/// Share of the corners of a which have a corner of b within 1.5 px of the place where they are seen there; the median
/// distance of those; and how many of 8x6 tiles of image a have three corners or more. The time is that of both images.
void repeatability(benchmark::State& state) {
  const View& view = views[state.range(0)];
  const auto detector = static_cast<Detector>(state.range(1));
  const double re = std::cos(view.rotation_rad) / view.scale, im = std::sin(view.rotation_rad) / view.scale;
  // The centre of both images looks at the same place but for a shift of 20 px.
  const Similarity2 from_a{1, 0, 1000, 2000};
  const Similarity2 from_b{1 / view.scale, view.rotation_rad, 1340 - re * 320 + im * 240, 2250 - im * 320 - re * 240};
  const test::Image a = test::render_texture(640, 480, from_a, 0.55, 0, 1, 1);
  const test::Image b = test::render_texture(640, 480, from_b, 0.55 * view.gain, 0, 1, 2);
  const Similarity2 b_from_a = test::compose(test::inverse(from_b), from_a);
  Points corners_a, corners_b;
  for (auto _ : state) {
    corners_a = detected(a, detector);
    corners_b = detected(b, detector);
  }
  int visible = 0;
  std::vector<double> distances;
  std::array<int, 48> tiles{};
  for (const auto& [ax, ay] : corners_a) {
    ++tiles[static_cast<std::size_t>(ay / 80) * 8 + static_cast<std::size_t>(ax / 80)];
    double x, y;
    test::apply(b_from_a, ax, ay, x, y);
    if (x < 14 || y < 14 || x > 625 || y > 465) continue;
    ++visible;
    double nearest = 1.5;
    for (const auto& [bx, by] : corners_b) nearest = std::min(nearest, std::hypot(bx - x, by - y));
    if (nearest < 1.5) distances.push_back(nearest);
  }
  std::sort(distances.begin(), distances.end());
  state.SetLabel(view.name);
  state.counters["corners"] = static_cast<double>(corners_a.size());
  state.counters["repeated_percent"] = 100 * static_cast<double>(distances.size()) / visible;
  state.counters["median_px"] = distances.empty() ? 0 : distances[distances.size() / 2];
  state.counters["tiles_of_48"] =
      static_cast<double>(std::count_if(tiles.begin(), tiles.end(), [](int count) { return count >= 3; }));
}
#ifdef ILP_HAVE_OPENCV
constexpr std::int64_t last_detector = opencv_sub_pixel;
#else
constexpr std::int64_t last_detector = ours;
#endif
BENCHMARK(repeatability)
    ->ArgNames({"view", "detector"})
    ->ArgsProduct({benchmark::CreateDenseRange(0, 5, 1), benchmark::CreateDenseRange(0, last_detector, 1)})
    ->Unit(benchmark::kMillisecond);

#ifdef ILP_HAVE_OPENCV
void opencv_good_features(benchmark::State& state) {
  cv::setNumThreads(1);
  const auto count = static_cast<int>(state.range(0));
  const cv::Mat grey(480, 640, CV_8UC1, const_cast<std::uint8_t*>(pair().a.pixels.data()));
  std::vector<cv::Point2f> corners;
  for (auto _ : state) cv::goodFeaturesToTrack(grey, corners, count, 1e-6, 5, cv::noArray(), 5, true, 0.04);
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(opencv_good_features)->Arg(1000)->Arg(2000)->Unit(benchmark::kMillisecond);

/// The cost of sub-pixel positions in addition to the detector, for as many corners as it gives.
void opencv_corner_sub_pix(benchmark::State& state) {
  cv::setNumThreads(1);
  const cv::Mat grey(480, 640, CV_8UC1, const_cast<std::uint8_t*>(pair().a.pixels.data()));
  std::vector<cv::Point2f> found, corners;
  cv::goodFeaturesToTrack(grey, found, static_cast<int>(state.range(0)), 1e-6, 5, cv::noArray(), 5, true, 0.04);
  for (auto _ : state) {
    corners = found;
    cv::cornerSubPix(grey, corners, {5, 5}, {-1, -1}, {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01});
  }
  state.counters["corners"] = static_cast<double>(corners.size());
}
BENCHMARK(opencv_corner_sub_pix)->Arg(1000)->Unit(benchmark::kMillisecond);
#endif

}  // namespace
}  // namespace ilp

BENCHMARK_MAIN();
