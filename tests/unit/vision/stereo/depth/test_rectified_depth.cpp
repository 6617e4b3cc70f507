// From two distorted views of known terrain, through rectification and matching, to depth on the reference's own
// pixels.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "tests/unit/vision/stereo/analytic_scene.hpp"
#include "tests/unit/vision/stereo/reconstruct.hpp"

namespace ilp::test {
namespace {

double hill(double x, double y) {
  return 8 * std::exp(-((x - 12) * (x - 12) + y * y) / 500) + 0.03 * x - 0.02 * y;
}
double plane(double x, double y) {
  return 0.05 * x - 0.03 * y;
}

struct Flight {
  const char* name;
  Vec3 baseline;
  Vec3 turn_a, turn_b;
  Terrain terrain;
};

class KnownTerrain : public ::testing::TestWithParam<Flight> {
 protected:
  KnownTerrain() : a_(views(GetParam()).first), b_(views(GetParam()).second) {
    status_ = plan_rectification(a_.camera, a_.cam_from_world, b_.cam_from_world, {80, 125}, {}, pair_, range_);
  }

  /// Rendered once per flight.
  static const std::pair<View, View>& views(const Flight& f) {
    static std::map<std::string, std::pair<View, View>> cache;
    auto found = cache.find(f.name);
    if (found == cache.end()) {
      const CameraModel camera = distorting_camera();
      View a = render_view(camera, looking_down({0, 0, 100}, f.turn_a), f.terrain, 3, 1.0, 1);
      View b = render_view(camera, looking_down(Vec3(0, 0, 100) + f.baseline, f.turn_b), f.terrain, 3, 1.0, 2);
      found = cache.emplace(f.name, std::pair(std::move(a), std::move(b))).first;
    }
    return found->second;
  }

  /// Image b sees the ground of this pixel of image a too.
  [[nodiscard]] bool seen_in_b(std::int32_t x, std::int32_t y) const {
    const Vec3 ground = ground_point(a_.camera, a_.cam_from_world, GetParam().terrain, x, y);
    return inside(b_.camera, pixel_of(b_.camera, b_.cam_from_world, ground));
  }

  const View& a_;
  const View& b_;
  Status status_;
  RectifiedPair pair_;
  DisparityRange range_;
};

TEST_P(KnownTerrain, MatchingPointsShareARowAndHaveDisparitiesInsideTheRange) {
  ASSERT_TRUE(status_.ok()) << status_name(status_.code);
  double worst_row = 0;
  double worst_disparity = 0;
  int checked = 0;
  for (std::int32_t y = 0; y < a_.camera.height; y += 7) {
    for (std::int32_t x = 0; x < a_.camera.width; x += 7) {
      if (!seen_in_b(x, y)) continue;
      const Vec3 ground = ground_point(a_.camera, a_.cam_from_world, GetParam().terrain, x, y);
      const Vec2 in_b = pixel_of(b_.camera, b_.cam_from_world, ground);
      const Vec2 left = rectified_left(pair_, normalised_from_pixel(a_.camera, Vec2(x, y)));
      const Vec2 right = rectified_right(pair_, normalised_from_pixel(b_.camera, in_b));
      worst_row = std::max(worst_row, std::fabs(left.y() - right.y()));
      const double disparity = left.x() - right.x();
      EXPECT_GT(disparity, range_.min_px);
      EXPECT_LT(disparity, range_.max_px);
      EXPECT_TRUE(left.x() > -1 && left.x() < pair_.width && left.y() > -1 && left.y() < pair_.height);
      EXPECT_TRUE(right.x() > -1 && right.x() < pair_.width);
      const Vec3 rect = pair_.rect_from_left * (a_.cam_from_world * ground);
      worst_disparity = std::max(worst_disparity, std::fabs(disparity - pair_.disparity_offset_px() -
                                                            pair_.focal_px * pair_.baseline / rect.z()));
      ++checked;
    }
  }
  EXPECT_GT(checked, 500);
  EXPECT_LT(worst_row, 1e-6);
  EXPECT_LT(worst_disparity, 1e-6);
}

TEST_P(KnownTerrain, ResampledImagesShowTheGroundOfTheirPixels) {
  ASSERT_TRUE(status_.ok());
  // Noise-free views, so that only interpolation and rounding remain.
  const Flight& f = GetParam();
  const View a = render_view(a_.camera, a_.cam_from_world, f.terrain, 1.2, 0, 1);
  const View b = render_view(b_.camera, b_.cam_from_world, f.terrain, 1.2, 0, 1);
  const Rectified r = resample(pair_, a, b, 37);
  std::vector<double> errors;
  for (std::int32_t y = 0; y < a.camera.height; y += 3) {
    for (std::int32_t x = 0; x < a.camera.width; x += 3) {
      const Vec2 p = rectified_left(pair_, normalised_from_pixel(a.camera, Vec2(x, y)));
      const auto u = static_cast<std::int32_t>(std::floor(p.x()));
      const auto v = static_cast<std::int32_t>(std::floor(p.y()));
      if (u < 0 || v < 0 || u + 1 >= pair_.width || v + 1 >= pair_.height) continue;
      if (std::as_const(r.left_valid).view().at(u, v) == 0 || std::as_const(r.left_valid).view().at(u + 1, v + 1) == 0)
        continue;
      const GrayView g = std::as_const(r.left).view();
      const double fu = p.x() - u;
      const double fv = p.y() - v;
      const double back = (1 - fv) * ((1 - fu) * g.at(u, v) + fu * g.at(u + 1, v)) +
                          fv * ((1 - fu) * g.at(u, v + 1) + fu * g.at(u + 1, v + 1));
      errors.push_back(std::fabs(back - std::as_const(a.image).view().at(x, y)));
    }
  }
  ASSERT_GT(errors.size(), 3000U);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.8);
  EXPECT_LT(errors[errors.size() * 99 / 100], 3.5);
}

TEST_P(KnownTerrain, DepthOnTheReferencePixelsIsRight) {
  ASSERT_TRUE(status_.ok());
  const DepthMap map = reconstruct(a_, b_, pair_, range_);
  std::vector<double> errors;
  double shared = 0;
  double valid = 0;
  double claimed_elsewhere = 0;
  double within = 0;
  for (std::int32_t y = 0; y < a_.camera.height; ++y) {
    for (std::int32_t x = 0; x < a_.camera.width; ++x) {
      const auto i = static_cast<std::size_t>(y * a_.camera.width + x);
      const bool common = seen_in_b(x, y);
      shared += common ? 1 : 0;
      if (!(map.sigma[i] > 0)) continue;
      if (!common) {
        claimed_elsewhere += 1;
        continue;
      }
      valid += 1;
      const double inverse = static_cast<double>(map.inverse_depth[i]);
      errors.push_back(std::fabs(1 / inverse / a_.depth[i] - 1));
      if (std::fabs(inverse - 1 / a_.depth[i]) < 2 * static_cast<double>(map.sigma[i])) within += 1;
    }
  }
  std::sort(errors.begin(), errors.end());
  const double median = errors[errors.size() / 2];
  const double high = errors[errors.size() * 95 / 100];
  // One pixel of disparity in relative depth.
  const double pixel = 100 / (pair_.focal_px * pair_.baseline);
  std::printf(
      "%s: %dx%d, %d disparities; median error %.4f %% (%.3f px), 95 %% %.4f %%, valid %.1f %%, within two sigma %.1f "
      "%%\n",
      GetParam().name, pair_.width, pair_.height, range_.count(), 100 * median, median / pixel, 100 * high,
      100 * valid / shared, 100 * within / valid);
  EXPECT_LT(median, 0.15 * pixel);
  EXPECT_LT(high, 0.6 * pixel);
  EXPECT_GT(valid / shared, 0.95);
  EXPECT_LT(claimed_elsewhere / shared, 0.01);
  EXPECT_GT(within / valid, 0.85);
}

INSTANTIATE_TEST_SUITE_P(
    Flights, KnownTerrain,
    ::testing::Values(Flight{"right", {20, 0, 0}, {0, 0, 0}, {0, 0, 0}, plane},
                      Flight{"left_tilted", {-18, 2, 1}, {0.03, -0.02, 0.05}, {-0.02, 0.03, -0.04}, hill},
                      Flight{"forward_in_image", {1, 20, -1}, {0.01, 0.02, 0}, {0.03, 0.01, 0.1}, hill},
                      Flight{"backward_in_image", {0, -19, 1}, {0, 0, 0.3}, {0.02, 0.02, 0.2}, hill},
                      Flight{"diagonal_turning", {13, 12, 2}, {0.05, 0, 0.6}, {0, 0.05, 0.2}, hill}),
    [](const auto& test) { return std::string(test.param.name); });

Status plan(const RigidTransform& a, const RigidTransform& b, DepthRange depth = {80, 125}) {
  RectifiedPair pair;
  DisparityRange range;
  return plan_rectification(distorting_camera(), a, b, depth, {}, pair, range);
}

TEST(PlanRectification, NamesWhyAPairCannotBeRectified) {
  const RigidTransform a = looking_down({0, 0, 100});
  const Status none = plan(a, looking_down({0, 0, 100}, {0, 0, 0.1}));
  EXPECT_EQ(none.code, StatusCode::rectification_impossible);
  EXPECT_EQ(none.b, 1);
  const Status apart = plan(a, looking_down({10, 0, 100}, {0, 1.4, 0}));
  EXPECT_EQ(apart.code, StatusCode::rectification_impossible);
  EXPECT_EQ(apart.b, 2);
  const Status descending = plan(a, looking_down({1, 0, 80}));
  EXPECT_EQ(descending.code, StatusCode::rectification_impossible);
  EXPECT_EQ(descending.b, 3);
  const Status elsewhere = plan(a, looking_down({400, 0, 100}));
  EXPECT_EQ(elsewhere.code, StatusCode::rectification_impossible);
  EXPECT_EQ(plan(a, looking_down({10, 0, 100}), {0, 10}).code, StatusCode::invalid_argument);
  EXPECT_EQ(plan(a, looking_down({10, 0, 100}), {20, 10}).code, StatusCode::invalid_argument);
}

TEST(PlanRectification, CutsADisparityRangeThatDoesNotFitAndSaysSo) {
  RectifiedPair pair;
  DisparityRange range;
  const Status status =
      plan_rectification(distorting_camera(limits::max_image_width, limits::max_image_height * 3 / 4),
                         looking_down({0, 0, 100}), looking_down({20, 0, 100}), {8, 125}, {}, pair, range);
  EXPECT_EQ(status.code, StatusCode::disparity_range_exceeded);
  EXPECT_EQ(range.count(), limits::max_disparities);
  // The far end, where most ground is, stays.
  const double farthest = pair.focal_px * pair.baseline / 125 + pair.disparity_offset_px();
  EXPECT_LT(range.min_px, farthest);
}

TEST(PlanRectification, LimitsHoldWhateverTheAttitude) {
  const CameraModel camera = distorting_camera(limits::max_image_width, limits::max_image_height);
  Rng rng(5);
  int planned = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const auto draw = [&](double range) { return range * (2 * rng.uniform() - 1); };
    const RigidTransform a = looking_down({0, 0, 100}, {draw(0.5), draw(0.5), draw(3)});
    const RigidTransform b = looking_down({draw(40), draw(40), 100 + draw(30)}, {draw(0.5), draw(0.5), draw(3)});
    RectifiedPair pair;
    DisparityRange range;
    const Status status = plan_rectification(camera, a, b, {60, 200}, {}, pair, range);
    if (!status.ok() && !status.is(StatusCode::disparity_range_exceeded)) continue;
    ++planned;
    EXPECT_LE(pair.width, limits::max_rectified_width);
    EXPECT_LE(pair.height, limits::max_rectified_height);
    EXPECT_LE(range.count(), limits::max_disparities);
    EXPECT_GE(range.count(), 1);
    EXPECT_GE(pair.focal_px, 0.5 * 0.5 * (camera.fx + camera.fy) - 1e-9);
  }
  EXPECT_GT(planned, 100);
}

TEST(DepthRangeOf, IgnoresTheOutlierShareAndWidensTheRest) {
  std::vector<Vec3> points;
  Rng rng(2);
  for (int i = 0; i < 1000; ++i) points.emplace_back(rng.uniform(), rng.uniform(), 90 + 20 * rng.uniform());
  for (int i = 0; i < 10; ++i) points.emplace_back(0, 0, 0.5 + i);
  for (int i = 0; i < 10; ++i) points.emplace_back(0, 0, 5000 + i);
  points.emplace_back(0, 0, -100);
  DepthRange range;
  ASSERT_TRUE(depth_range_of({}, points.data(), points.size(), 0.015, 0.1, range).ok());
  EXPECT_NEAR(range.nearest, 88, 1.5);
  EXPECT_NEAR(range.farthest, 112, 1.5);
  EXPECT_EQ(depth_range_of({}, points.data(), 5, 0.0, 0.1, range).code, StatusCode::too_few_matches);
}

}  // namespace
}  // namespace ilp::test
