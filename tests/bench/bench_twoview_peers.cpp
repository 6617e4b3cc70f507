// Robust two-view models beside OpenCV's USAC on the same pairs, with the errors that go with the times. Arguments:
// scene (test::scene_kinds), outliers in per cent, noise in tenths of a pixel; a new pair and seed each time. Counters
// over 60 pairs: median errors of poses in degrees and failures over 10 degrees; of fundamental matrices the median and
// 90th percentile of the rms distance from exact matches, px.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "fsw/vision/twoview/robust/robust_models.hpp"
#include "fsw/vision/twoview/robust/two_view_workspace.hpp"
#include "tests/unit/vision/twoview/relative_pose_trials.hpp"
#include "tests/unit/vision/twoview/robust/fundamental_error.hpp"

#ifdef ILP_HAVE_OPENCV_CALIB3D
#include <opencv2/calib3d.hpp>
#endif

namespace ilp {
namespace {

constexpr std::size_t pair_count = 60;
constexpr double confidence = 0.9999;
constexpr int max_trials = 1000;

TwoViewWorkspace workspace;
InlierMask inliers;

test::TrialCell cell_of(const benchmark::State& state) {
  return {static_cast<int>(state.range(0)), static_cast<int>(state.range(1)), static_cast<int>(state.range(2))};
}

std::vector<test::PoseCase> pairs_of(const test::TrialCell& cell) {
  std::vector<test::PoseCase> pairs;
  for (std::size_t i = 0; i < pair_count; ++i) pairs.push_back(test::make_trial(cell, i));
  return pairs;
}

RansacParams params_of(const test::TrialCell& cell, std::uint64_t seed) {
  RansacParams params;
  params.threshold_px = 0.2 * cell.noise;  // two sigma
  params.confidence = confidence;
  params.max_trials = max_trials;
  params.seed = seed;
  return params;
}

struct Errors {
  std::vector<double> rotation, direction;
  int failures = 0;

  void add(const RigidTransform& pose, const RigidTransform& truth) {
    rotation.push_back(test::rotation_error_deg(pose, truth));
    direction.push_back(test::direction_error_deg(pose, truth));
    failures += rotation.back() > 10 || direction.back() > 10 ? 1 : 0;
  }

  void report(benchmark::State& state) const {
    state.counters["rotation_deg"] = test::median(rotation);
    state.counters["direction_deg"] = test::median(direction);
    state.counters["failures"] = failures;
  }
};

void report_distances(benchmark::State& state, std::vector<double> distances) {
  std::sort(distances.begin(), distances.end());
  state.counters["median_px"] = test::median(distances);
  state.counters["p90_px"] = distances[distances.size() * 9 / 10];
}

/// Times `estimate(pair, seed)`.
template <typename Estimate>
void over_pairs(benchmark::State& state, Estimate estimate) {
  const std::vector<test::PoseCase> pairs = pairs_of(cell_of(state));
  std::uint64_t next = 0;
  for (auto _ : state) {
    estimate(pairs[next % pair_count], next + 1);
    ++next;
  }
}

RigidTransform our_pose(const test::PoseCase& pair, const test::TrialCell& cell, std::uint64_t seed) {
  TwoViewResult result;
  Status status =
      estimate_two_view(pair.pairs, pair.camera, pair.camera, params_of(cell, seed), workspace, inliers, result);
  benchmark::DoNotOptimize(status);
  return result.b_from_a;
}

void pose_ours(benchmark::State& state) {
  const test::TrialCell cell = cell_of(state);
  over_pairs(state, [&](const test::PoseCase& pair, std::uint64_t seed) {
    benchmark::DoNotOptimize(our_pose(pair, cell, seed));
  });
  Errors errors;
  std::uint64_t seed = 1;
  for (const test::PoseCase& pair : pairs_of(cell)) errors.add(our_pose(pair, cell, seed++), pair.truth);
  errors.report(state);
}

Mat3 our_fundamental(const test::PoseCase& pair, const test::TrialCell& cell, std::uint64_t seed) {
  FundamentalResult result;
  Status status = estimate_fundamental(pair.pairs, params_of(cell, seed), workspace, inliers, result);
  benchmark::DoNotOptimize(status);
  return result.fundamental;
}

void fundamental_ours(benchmark::State& state) {
  const test::TrialCell cell = cell_of(state);
  over_pairs(state, [&](const test::PoseCase& pair, std::uint64_t seed) {
    benchmark::DoNotOptimize(our_fundamental(pair, cell, seed));
  });
  std::vector<double> distances;
  for (const test::PoseCase& pair : pairs_of(cell)) {
    distances.push_back(test::error_of_fundamental(pair, our_fundamental(pair, cell, distances.size() + 1)));
  }
  report_distances(state, distances);
}

void homography_ours(benchmark::State& state) {
  const test::TrialCell cell = cell_of(state);
  over_pairs(state, [&](const test::PoseCase& pair, std::uint64_t seed) {
    HomographyResult result;
    Status status = estimate_homography(pair.pairs, params_of(cell, seed), workspace, inliers, result);
    benchmark::DoNotOptimize(status);
    benchmark::DoNotOptimize(result);
  });
}

#ifdef ILP_HAVE_OPENCV_CALIB3D

struct Points {
  std::vector<cv::Point2d> a, b;

  explicit Points(const test::PoseCase& pair) {
    for (const PointPair& p : pair.pairs) {
      a.emplace_back(p.xa, p.ya);
      b.emplace_back(p.xb, p.yb);
    }
  }
};

cv::Mat camera_matrix(const CameraModel& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
}

/// OpenCV's time is that of findEssentialMat alone; recoverPose, which only the errors need, is not counted.
RigidTransform opencv_pose(const test::PoseCase& pair, const cv::Mat& essential, const Points& points,
                           const cv::Mat& mask) {
  RigidTransform pose;
  if (essential.rows != 3 || essential.cols != 3) return {-Mat3::Identity(), Vec3::UnitX()};
  cv::Mat rotation;
  cv::Mat translation;
  cv::Mat support = mask.clone();
  cv::recoverPose(essential, points.a, points.b, camera_matrix(pair.camera), rotation, translation, support);
  for (int i = 0; i < 9; ++i) pose.rotation(i / 3, i % 3) = rotation.at<double>(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) pose.translation[i] = translation.at<double>(i);
  return pose;
}

cv::Mat opencv_essential(const test::PoseCase& pair, const Points& points, const test::TrialCell& cell, int method,
                         cv::Mat& mask) {
  return cv::findEssentialMat(points.a, points.b, camera_matrix(pair.camera), method, confidence, 0.2 * cell.noise,
                              max_trials, mask);
}

/// Times `estimate(pair, points)`, on one thread.
template <typename Estimate>
void over_pairs_opencv(benchmark::State& state, Estimate estimate) {
  cv::setNumThreads(1);
  const std::vector<test::PoseCase> pairs = pairs_of(cell_of(state));
  const std::vector<Points> points(pairs.begin(), pairs.end());
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(estimate(pairs[next], points[next]));
    next = (next + 1) % pair_count;
  }
}

void pose_opencv(benchmark::State& state, int method) {
  const test::TrialCell cell = cell_of(state);
  cv::Mat mask;
  const auto estimate = [&](const test::PoseCase& pair, const Points& points) {
    return opencv_essential(pair, points, cell, method, mask);
  };
  over_pairs_opencv(state, estimate);
  Errors errors;
  for (const test::PoseCase& pair : pairs_of(cell)) {
    const Points points(pair);
    const cv::Mat essential = estimate(pair, points);
    errors.add(opencv_pose(pair, essential, points, mask), pair.truth);
  }
  errors.report(state);
}

void fundamental_opencv(benchmark::State& state, int method) {
  const test::TrialCell cell = cell_of(state);
  const auto estimate = [&](const test::PoseCase&, const Points& points) {
    cv::Mat mask;
    return cv::findFundamentalMat(points.a, points.b, method, 0.2 * cell.noise, confidence, max_trials, mask);
  };
  over_pairs_opencv(state, estimate);
  std::vector<double> distances;
  for (const test::PoseCase& pair : pairs_of(cell)) {
    const cv::Mat found = estimate(pair, Points(pair));
    Mat3 f = Mat3::Ones();
    for (int i = 0; i < 9 && found.rows == 3; ++i) f(i / 3, i % 3) = found.at<double>(i / 3, i % 3);
    distances.push_back(test::error_of_fundamental(pair, f));
  }
  report_distances(state, distances);
}

void homography_opencv(benchmark::State& state, int method) {
  const test::TrialCell cell = cell_of(state);
  over_pairs_opencv(state, [&](const test::PoseCase&, const Points& points) {
    cv::Mat mask;
    return cv::findHomography(points.a, points.b, method, 0.2 * cell.noise, mask, max_trials, confidence);
  });
}

#endif

void all_cells(benchmark::internal::Benchmark* bench) {
  for (int scene = 0; scene < 6; ++scene) {
    for (const int outliers : {30, 50}) {
      for (const int noise : {5, 10}) bench->Args({scene, outliers, noise});
    }
  }
  bench->Unit(benchmark::kMillisecond);
}

void cells_with_relief(benchmark::internal::Benchmark* bench) {
  bench->Args({0, 30, 5})->Args({0, 50, 10})->Args({4, 30, 5})->Args({4, 50, 10})->Unit(benchmark::kMillisecond);
}

void planes(benchmark::internal::Benchmark* bench) {
  bench->Args({1, 30, 5})->Args({1, 50, 10})->Unit(benchmark::kMillisecond);
}

BENCHMARK(pose_ours)->Apply(all_cells);
BENCHMARK(fundamental_ours)->Apply(cells_with_relief);
BENCHMARK(homography_ours)->Apply(planes);
#ifdef ILP_HAVE_OPENCV_CALIB3D
BENCHMARK_CAPTURE(pose_opencv, magsac, cv::USAC_MAGSAC)->Apply(all_cells);
BENCHMARK_CAPTURE(pose_opencv, usac, cv::USAC_DEFAULT)->Apply(all_cells);
BENCHMARK_CAPTURE(fundamental_opencv, magsac, cv::USAC_MAGSAC)->Apply(cells_with_relief);
BENCHMARK_CAPTURE(fundamental_opencv, usac, cv::USAC_DEFAULT)->Apply(cells_with_relief);
BENCHMARK_CAPTURE(homography_opencv, magsac, cv::USAC_MAGSAC)->Apply(planes);
BENCHMARK_CAPTURE(homography_opencv, usac, cv::USAC_DEFAULT)->Apply(planes);
#endif

}  // namespace
}  // namespace ilp
