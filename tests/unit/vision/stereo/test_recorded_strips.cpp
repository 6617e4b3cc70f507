// Dense depth of recorded aerial strips against the sparse points of an independent reconstruction.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <tuple>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

std::vector<Vec3> read_points(const std::string& folder) {
  std::ifstream file(data_root + folder + "/reference_points.txt");
  std::vector<Vec3> points;
  for (std::string line; std::getline(file, line);) {
    std::istringstream in(line);
    Vec3 p;
    if (line[0] != '#' && in >> p.x() >> p.y() >> p.z()) points.push_back(p);
  }
  return points;
}

RigidTransform pose_of(const StripImage& image) {
  RigidTransform t;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) t.rotation(i, j) = image.rotation[i][j];
  }
  t.translation = -(t.rotation * Vec3(image.centre[0], image.centre[1], image.centre[2]));
  return t;
}

/// Pixel of a world point, or one outside.
Vec2 project(const CameraModel& camera, const RigidTransform& pose, const Vec3& world) {
  const Vec3 p = pose * world;
  if (!(p.z() > 0)) return {-1e9, -1e9};
  return pixel_from_normalised(camera, Vec2(p.x() / p.z(), p.y() / p.z()));
}

bool well_inside(const CameraModel& camera, const Vec2& p) {
  constexpr double margin = 6;
  return p.x() > margin && p.y() > margin && p.x() < camera.width - margin && p.y() < camera.height - margin;
}

struct PairResult {
  double valid_at_points = 0;
  std::vector<double> errors_px;  ///< of disparity, at the points with depth
};

PairResult reconstruct(const std::string& folder, const StripImage& a, const StripImage& b,
                       const std::vector<Vec3>& points, StereoMatcherChoice choice) {
  static const auto workspace = std::make_unique<StereoWorkspace>();
  const CameraModel& camera = a.camera;
  const RigidTransform pose_a = pose_of(a);
  const RigidTransform pose_b = pose_of(b);
  std::vector<Vec3> seen;
  for (const Vec3& p : points) {
    if (well_inside(camera, project(camera, pose_a, p)) && well_inside(camera, project(camera, pose_b, p)))
      seen.push_back(p);
  }
  PairResult result;
  DepthRange depth_range;
  EXPECT_TRUE(depth_range_of(pose_a, seen.data(), seen.size(), 0.01, 0.3, depth_range).ok());
  RectifiedPair pair;
  DisparityRange range;
  const Status planned = plan_rectification(camera, pose_a, pose_b, depth_range, {}, pair, range);
  EXPECT_TRUE(planned.ok()) << a.name << " " << status_name(planned.code) << " " << planned.b;
  if (!planned.ok()) return result;
  Image left(pair.width, pair.height);
  Image right = left;
  Image left_valid = left;
  Image right_valid = left;
  EXPECT_TRUE(resample_rows(pair, Side::left, camera, read_strip_image(folder, a.name).view(), 0, pair.height,
                            left.view(), left_valid.view())
                  .ok());
  EXPECT_TRUE(resample_rows(pair, Side::right, camera, read_strip_image(folder, b.name).view(), 0, pair.height,
                            right.view(), right_valid.view())
                  .ok());
  std::vector<float> disparity(left.pixels.size());
  std::vector<float> sigma(left.pixels.size());
  const DisparityView view{{disparity.data(), pair.width, pair.height}, {sigma.data(), pair.width, pair.height}};
  StereoParams params{.matcher = choice};
  StereoMatcher matcher;
  EXPECT_TRUE(
      matcher.begin(left.view(), right.view(), left_valid.view(), right_valid.view(), range, params, *workspace, view)
          .ok());
  EXPECT_TRUE(do_all([&] { return matcher.step(64); }).ok());
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  std::vector<float> inverse_depth(pixels);
  std::vector<float> depth_sigma(pixels);
  const std::int32_t words = supported_words(camera.width);
  std::vector<std::uint64_t> supported(static_cast<std::size_t>(words * camera.height));
  EXPECT_TRUE(depth_rows(pair, camera, matcher.result(), 0, camera.height,
                         {{inverse_depth.data(), camera.width, camera.height},
                          {depth_sigma.data(), camera.width, camera.height},
                          {supported.data(), words, camera.height}})
                  .ok());
  for (const Vec3& p : seen) {
    const Vec2 pixel = project(camera, pose_a, p);
    const auto i = static_cast<std::size_t>(std::lround(pixel.y()) * camera.width + std::lround(pixel.x()));
    if (depth_sigma[i] == 0) continue;
    const double truth = 1 / (pose_a * p).z();
    result.errors_px.push_back(std::fabs(static_cast<double>(inverse_depth[i]) - truth) * pair.focal_px *
                               pair.baseline);
  }
  result.valid_at_points = static_cast<double>(result.errors_px.size()) / static_cast<double>(seen.size());
  std::sort(result.errors_px.begin(), result.errors_px.end());
  const std::size_t n = result.errors_px.size();
  std::printf("%s-%s: %dx%d, %d disparities, %zu points: valid %.1f %%, median %.3f px, 90 %% %.3f px\n",
              a.name.c_str(), b.name.c_str(), pair.width, pair.height, range.count(), seen.size(),
              100 * result.valid_at_points, result.errors_px[n / 2], result.errors_px[n * 9 / 10]);
  return result;
}

class RecordedStrip : public ::testing::TestWithParam<std::tuple<const char*, StereoMatcherChoice>> {};

TEST_P(RecordedStrip, DepthAgreesWithTheReferencePoints) {
  const std::string folder = std::get<0>(GetParam());
  const std::vector<StripImage> strip = read_strip(folder);
  if (strip.empty()) GTEST_SKIP() << "data set " << folder << " is absent";
  if (strip[0].camera.width > limits::max_image_width) GTEST_SKIP() << "images exceed this profile";
  const std::vector<Vec3> points = read_points(folder);
  ASSERT_GT(points.size(), 100U);
  std::vector<double> errors;
  double valid = 0;
  const std::size_t pairs = std::min<std::size_t>(4, strip.size() - 1);
  for (std::size_t i = 0; i < pairs; ++i) {
    const PairResult r = reconstruct(folder, strip[i], strip[i + 1], points, std::get<1>(GetParam()));
    errors.insert(errors.end(), r.errors_px.begin(), r.errors_px.end());
    valid += r.valid_at_points;
  }
  std::sort(errors.begin(), errors.end());
  ASSERT_GT(errors.size(), 200U);
  std::printf("%s, %s: valid %.2f %%, median %.3f px, 90 %% %.3f px\n", folder.c_str(),
              name_of(std::get<1>(GetParam())), 100 * valid / static_cast<double>(pairs), errors[errors.size() / 2],
              errors[errors.size() * 9 / 10]);
  EXPECT_GT(valid / static_cast<double>(pairs), 0.98);
  EXPECT_LT(errors[errors.size() / 2], 0.4);
  EXPECT_LT(errors[errors.size() * 9 / 10], 2.0);
}

INSTANTIATE_TEST_SUITE_P(
    Strips, RecordedStrip,
    ::testing::Combine(::testing::Values("aerial_caliterra_a", "aerial_caliterra_climb", "aerial_coal_oil_point"),
                       ::testing::Values(StereoMatcherChoice::semi_global, StereoMatcherChoice::ordered_scanline)),
    [](const auto& test) { return std::string(std::get<0>(test.param)) + "_" + name_of(std::get<1>(test.param)); });

}  // namespace
}  // namespace ilp::test
