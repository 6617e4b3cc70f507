// Polar rectification: descents, ascents and oblique motion over known terrain, the epipole inside, at the edge of and
// outside the image.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "cfg/limits.hpp"
#include "fsw/base/math.hpp"
#include "fsw/vision/stereo/rectify/polar_coordinates.hpp"
#include "fsw/vision/stereo/rectify/polar_rectification.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"
#include "tests/unit/vision/stereo/reconstruct.hpp"

namespace ilp::test {
namespace {

double hill(double x, double y) {
  return 8 * std::exp(-((x - 12) * (x - 12) + y * y) / 500) + 0.03 * x - 0.02 * y;
}
double level(double, double) {
  return 0;
}

struct Flight {
  const char* name;
  Vec3 baseline;
  Vec3 turn_a, turn_b;
  Terrain terrain;
};

void PrintTo(const Flight& flight, std::ostream* out) {
  *out << flight.name;
}

struct Scene {
  View a, b;
};

const Scene& scene_of(const Flight& f) {
  static std::map<std::string, Scene> cache;
  auto found = cache.find(f.name);
  if (found == cache.end()) {
    const CameraModel camera = distorting_camera();
    const RigidTransform a = looking_down({0, 0, 100}, f.turn_a);
    const RigidTransform b = looking_down(Vec3(0, 0, 100) + f.baseline, f.turn_b);
    found = cache
                .emplace(f.name, Scene{render_view(camera, a, f.terrain, 3, 1.0, 1),
                                       render_view(camera, b, f.terrain, 3, 1.0, 2)})
                .first;
  }
  return found->second;
}

constexpr DepthRange depths{80, 125};

/// Angle between the ray of a pixel and the nearer end of the baseline, rad.
double angle_from_epipole(const View& a, const View& b, double x, double y) {
  const Vec2 n = normalised_from_pixel(a.camera, Vec2(x, y));
  const Vec3 ray = a.cam_from_world.rotation.transpose() * Vec3(n.x(), n.y(), 1).normalized();
  const Vec3 along = (centre_of(b.cam_from_world) - centre_of(a.cam_from_world)).normalized();
  return std::asin(std::min(1.0, ray.cross(along).norm()));
}

struct Statistics {
  double shared = 0, valid = 0, within_one = 0, within_two = 0, claimed_elsewhere = 0, in_disc = 0;
  std::vector<double> errors;     ///< relative, of depth
  std::vector<double> errors_px;  ///< of inverse depth, as parallax in px of the reference

  [[nodiscard]] static double quantile(const std::vector<double>& v, double q) {
    std::vector<double> sorted = v;
    std::sort(sorted.begin(), sorted.end());
    return sorted.empty() ? 1e300 : sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))];
  }
};

Statistics compare(const Flight& f, const DepthMap& map, double disc_rad) {
  const auto& [a, b] = scene_of(f);
  Statistics s;
  for (std::int32_t y = 0; y < a.camera.height; ++y) {
    for (std::int32_t x = 0; x < a.camera.width; ++x) {
      const auto i = static_cast<std::size_t>(y * a.camera.width + x);
      const Vec3 ground = ground_point(a.camera, a.cam_from_world, f.terrain, x, y);
      const double angle = angle_from_epipole(a, b, x, y);
      const bool has_depth = map.sigma[i] > 0;
      if (angle < disc_rad) {
        s.in_disc += has_depth ? 1 : 0;
        continue;
      }
      const bool common = inside(b.camera, pixel_of(b.camera, b.cam_from_world, ground));
      s.shared += common ? 1 : 0;
      if (!has_depth) continue;
      if (!common) {
        s.claimed_elsewhere += 1;
        continue;
      }
      s.valid += 1;
      const double inverse = static_cast<double>(map.inverse_depth[i]);
      const double error = std::fabs(inverse - 1 / a.depth[i]);
      s.errors.push_back(std::fabs(1 / inverse / a.depth[i] - 1));
      s.errors_px.push_back(error * f.baseline.norm() * a.camera.fx * std::sin(angle));
      if (error < static_cast<double>(map.sigma[i])) s.within_one += 1;
      if (error < 2 * static_cast<double>(map.sigma[i])) s.within_two += 1;
    }
  }
  return s;
}

class PolarTerrain : public ::testing::TestWithParam<Flight> {
 protected:
  PolarTerrain() : a_(scene_of(GetParam()).a), b_(scene_of(GetParam()).b) {
    status_ = plan_panels(a_.camera, a_.cam_from_world, b_.cam_from_world, depths, {}, plan_);
  }
  [[nodiscard]] double disc_rad() const { return plan_.blind_radius_px / (0.5 * (a_.camera.fx + a_.camera.fy)); }

  const View& a_;
  const View& b_;
  Status status_;
  RectificationPlan plan_;
};

/// The one panel that gives depth for a pixel; null when there is none.
const RectifiedPanel* panel_at(const RectificationPlan& plan, const Vec2& normalised) {
  const RectifiedPanel* found = nullptr;
  for (std::size_t i = 0; i < plan.count; ++i) {
    if (!gives_depth(plan.panels[i].pair, normalised)) continue;
    EXPECT_EQ(found, nullptr) << "two panels give depth for one pixel";
    found = &plan.panels[i];
  }
  return found;
}

TEST_P(PolarTerrain, MatchingPointsShareARowOfOnePanelAndHaveDisparitiesInsideItsRange) {
  ASSERT_TRUE(status_.ok());
  double worst_row = 0;
  int checked = 0;
  for (std::int32_t y = 0; y < a_.camera.height; y += 3) {
    for (std::int32_t x = 0; x < a_.camera.width; x += 3) {
      const Vec3 ground = ground_point(a_.camera, a_.cam_from_world, GetParam().terrain, x, y);
      const Vec2 in_b = pixel_of(b_.camera, b_.cam_from_world, ground);
      if (!inside(b_.camera, in_b) || angle_from_epipole(a_, b_, x, y) < disc_rad()) continue;
      const Vec2 normalised = normalised_from_pixel(a_.camera, Vec2(x, y));
      const RectifiedPanel* panel = panel_at(plan_, normalised);
      ASSERT_NE(panel, nullptr) << x << " " << y;
      const RectifiedPair& pair = panel->pair;
      const Vec2 left = rectified_left(pair, normalised);
      const Vec2 right = rectified_right(pair, normalised_from_pixel(b_.camera, in_b));
      worst_row = std::max(worst_row, std::fabs(left.y() - right.y()));
      EXPECT_GT(left.x() - right.x(), panel->range.min_px);
      EXPECT_LT(left.x() - right.x(), panel->range.max_px);
      EXPECT_TRUE(left.x() > 0 && left.x() < pair.width - 1 && left.y() > 0 && left.y() < pair.height - 1);
      EXPECT_TRUE(right.x() > 0 && right.x() < pair.width - 1);
      ++checked;
    }
  }
  EXPECT_GT(checked, 3000);
  EXPECT_LT(worst_row, 1e-6);
}

TEST_P(PolarTerrain, ResampledImagesShowTheGroundOfTheirPixels) {
  ASSERT_TRUE(status_.ok());
  // Smooth and without noise, so that only interpolation and rounding remain.
  const View a = render_view(a_.camera, a_.cam_from_world, GetParam().terrain, 1.2, 0, 1);
  const View b = render_view(b_.camera, b_.cam_from_world, GetParam().terrain, 1.2, 0, 1);
  std::vector<double> errors;
  for (std::size_t i = 0; i < plan_.count; ++i) {
    const RectifiedPair& pair = plan_.panels[i].pair;
    const Rectified r = resample(pair, a, b, 37);
    const auto compare_side = [&](const View& view, const Image& rectified, const Image& valid, auto place) {
      for (std::int32_t y = 0; y < view.camera.height; y += 5) {
        for (std::int32_t x = 0; x < view.camera.width; x += 5) {
          const Vec2 p = place(pair, normalised_from_pixel(view.camera, Vec2(x, y)));
          if (!(p.x() >= 0 && p.y() >= 0 && p.x() < pair.width - 1 && p.y() < pair.height - 1)) continue;
          const auto u = static_cast<std::int32_t>(std::floor(p.x()));
          const auto v = static_cast<std::int32_t>(std::floor(p.y()));
          if (valid.view().at(u, v) == 0 || valid.view().at(u + 1, v + 1) == 0) continue;
          const GrayView g = rectified.view();
          const double fu = p.x() - u, fv = p.y() - v;
          const double back = (1 - fv) * ((1 - fu) * g.at(u, v) + fu * g.at(u + 1, v)) +
                              fv * ((1 - fu) * g.at(u, v + 1) + fu * g.at(u + 1, v + 1));
          errors.push_back(std::fabs(back - view.image.view().at(x, y)));
        }
      }
    };
    compare_side(a, r.left, r.left_valid, rectified_left);
    compare_side(b, r.right, r.right_valid, rectified_right);
  }
  ASSERT_GT(errors.size(), 3000U);
  std::sort(errors.begin(), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 1);
  EXPECT_LT(errors[errors.size() * 99 / 100], 5);
}

TEST_P(PolarTerrain, OutsideTheDiscTheFarthestGroundMovesByTheLeastParallax) {
  ASSERT_TRUE(status_.ok());
  // Rays at the edge of the disc, all around the nearer end of the baseline, to ground at the far end of the range.
  const Vec3 ca = centre_of(a_.cam_from_world), cb = centre_of(b_.cam_from_world);
  const Vec3 view_a = a_.cam_from_world.rotation.row(2).transpose();
  Vec3 along = (cb - ca).normalized();
  if (along.dot(view_a) < 0) along = -along;
  const Vec3 across = along.unitOrthogonal(), other = along.cross(across);
  int seen = 0;
  for (int k = 0; k < 16; ++k) {
    const double phi = k * pi / 8, edge = disc_rad();
    const Vec3 ray = std::cos(edge) * along + std::sin(edge) * (std::cos(phi) * across + std::sin(phi) * other);
    const Vec3 in_a = a_.cam_from_world.rotation * ray;
    if (!(in_a.z() > 0) ||
        !inside(a_.camera, pixel_from_normalised(a_.camera, {in_a.x() / in_a.z(), in_a.y() / in_a.z()})))
      continue;
    ++seen;
    const Vec3 point = ca + ray * (depths.farthest / in_a.z());
    const double parallax = std::acos(ray.dot((point - cb).normalized())) * 0.5 * (a_.camera.fx + a_.camera.fy);
    // The right camera is nearer or farther by up to the baseline, and off the axis a ray is longer than its depth.
    EXPECT_NEAR(parallax, RectificationParams{}.min_parallax_px, 0.3 * RectificationParams{}.min_parallax_px);
  }
  if (GetParam().baseline.head<2>().norm() < 0.4 * std::fabs(GetParam().baseline.z())) {
    EXPECT_EQ(seen, 16);
  }
}

TEST_P(PolarTerrain, DepthOnTheReferencePixelsIsRight) {
  ASSERT_TRUE(status_.ok()) << status_name(status_.code) << " " << status_.b;
  ASSERT_EQ(plan_.method, RectificationMethod::polar);
  const Statistics s = compare(GetParam(), reconstruct(a_, b_, plan_), disc_rad());
  const double median = s.quantile(s.errors, 0.5), median_px = s.quantile(s.errors_px, 0.5);
  double area = 0;
  for (std::size_t i = 0; i < plan_.count; ++i) area += plan_.panels[i].pair.width * plan_.panels[i].pair.height;
  std::printf(
      "%s: %zu panels, %.2f of the image's pixels, resolution %.2f, disc %.1f px; depth error median %.3f %%, 95 %% "
      "%.3f %%; parallax median %.3f px, 95 %% %.3f px; valid %.1f %%, elsewhere %.2f %%, within 1 sigma %.1f %%, 2 "
      "%.1f %%\n",
      GetParam().name, plan_.count, area / (a_.camera.width * a_.camera.height), plan_.resolution,
      plan_.blind_radius_px, 100 * median, 100 * s.quantile(s.errors, 0.95), median_px, s.quantile(s.errors_px, 0.95),
      100 * s.valid / s.shared, 100 * s.claimed_elsewhere / s.shared, 100 * s.within_one / s.valid,
      100 * s.within_two / s.valid);
  EXPECT_LT(median_px, 0.1);
  EXPECT_LT(s.quantile(s.errors_px, 0.95), 0.35);
  EXPECT_LT(median, 0.01);
  EXPECT_GT(s.valid / s.shared, 0.98);
  // Windows and disparities of half a pixel reach a little over the border of the common view, no further.
  EXPECT_LT(s.claimed_elsewhere, 1.5 * 2 * (a_.camera.width + a_.camera.height));
  EXPECT_GT(s.within_one / s.valid, 0.6);
  EXPECT_GT(s.within_two / s.valid, 0.94);
  EXPECT_EQ(s.in_disc, 0);
}

INSTANTIATE_TEST_SUITE_P(
    Flights, PolarTerrain,
    ::testing::Values(Flight{"descent", {0, 0, -18}, {0, 0, 0}, {0, 0, 0}, hill},
                      Flight{"descent_level", {0, 0, -12}, {0, 0, 0}, {0, 0, 0}, level},
                      Flight{"ascent", {0, 0, 16}, {0, 0, 0}, {0, 0, 0.1}, hill},
                      Flight{"descent_drift_turn", {4, -3, -15}, {0.03, -0.02, 0.05}, {-0.02, 0.03, -0.3}, hill},
                      Flight{"epipole_at_edge", {9, 0, -18}, {0, 0, 0}, {0, 0, 0.02}, hill},
                      Flight{"epipole_at_corner", {9, 7, -18}, {0, 0, 0}, {0.02, 0, 0}, hill},
                      Flight{"epipole_just_outside", {13, 0, -18}, {0, 0, 0}, {0, 0.03, 0}, hill},
                      Flight{"ascent_epipole_outside", {0, 14, 18}, {0, 0, 0}, {0, 0, 0}, hill}),
    [](const auto& test) { return std::string(test.param.name); });

// Motion that either method can treat: 45 to 60 degrees from the optical axis, both ways.
class EitherMethod : public ::testing::TestWithParam<Flight> {};

TEST_P(EitherMethod, GivesTheSameDepth) {
  const auto& [a, b] = scene_of(GetParam());
  RectifiedPair pair;
  DisparityRange range;
  ASSERT_TRUE(plan_rectification(a.camera, a.cam_from_world, b.cam_from_world, depths, {}, pair, range).ok());
  RectificationPlan plan;
  ASSERT_TRUE(plan_polar_rectification(a.camera, a.cam_from_world, b.cam_from_world, depths, {}, plan).ok());
  const DepthMap one = reconstruct(a, b, pair, range), other = reconstruct(a, b, plan);
  double both = 0, either = 0, agree = 0;
  std::vector<double> signed_difference;
  for (std::size_t i = 0; i < one.sigma.size(); ++i) {
    either += one.sigma[i] > 0 || other.sigma[i] > 0 ? 1 : 0;
    if (!(one.sigma[i] > 0) || !(other.sigma[i] > 0)) continue;
    both += 1;
    const double difference = static_cast<double>(one.inverse_depth[i]) - static_cast<double>(other.inverse_depth[i]);
    const double sigma = std::hypot(static_cast<double>(one.sigma[i]), static_cast<double>(other.sigma[i]));
    agree += std::fabs(difference) < 2 * sigma ? 1 : 0;
    signed_difference.push_back(difference / sigma);
  }
  std::sort(signed_difference.begin(), signed_difference.end());
  const double median = signed_difference[signed_difference.size() / 2];
  std::printf("%s: both %.1f %%, agree within two sigma %.1f %%, median difference %.3f sigma, %zu panels\n",
              GetParam().name, 100 * both / either, 100 * agree / both, median, plan.count);
  EXPECT_GT(both / either, 0.96);
  EXPECT_GT(agree / both, 0.96);
  EXPECT_LT(std::fabs(median), 0.1);
}

INSTANTIATE_TEST_SUITE_P(Flights, EitherMethod,
                         ::testing::Values(Flight{"sideways", {20, 0, 0}, {0, 0, 0}, {0, 0, 0}, hill},
                                           Flight{"oblique_down", {14, 5, -12}, {0, 0, 0}, {0.02, 0.03, 0.1}, hill},
                                           Flight{"oblique_up", {5, 16, 11}, {0.02, 0, 0}, {0, 0, -0.2}, hill}),
                         [](const auto& test) { return std::string(test.param.name); });

Status plan_of(const RigidTransform& a, const RigidTransform& b, DepthRange depth = depths) {
  RectificationPlan plan;
  return plan_panels(distorting_camera(), a, b, depth, {}, plan);
}

TEST(PlanPanels, NamesWhyAPairCannotBeRectified) {
  const RigidTransform a = looking_down({0, 0, 100});
  const auto reason = [](const Status& status) {
    EXPECT_EQ(status.code, StatusCode::rectification_impossible);
    return status.b;
  };
  EXPECT_EQ(reason(plan_of(a, looking_down({0, 0, 100}, {0, 0, 0.1}))), 1);
  EXPECT_EQ(reason(plan_of(a, looking_down({0, 0, 80}, {0, 1.4, 0}))), 2);
  EXPECT_EQ(reason(plan_of(a, looking_down({400, 0, 100}))), 4);
  EXPECT_EQ(reason(plan_of(a, looking_down({0, 0, 99.5}))), 6);
  EXPECT_EQ(plan_of(a, looking_down({0, 0, 80}), {0, 10}).code, StatusCode::invalid_argument);
  EXPECT_EQ(plan_of(a, looking_down({0, 0, 80}), {20, 10}).code, StatusCode::invalid_argument);
}

TEST(PlanPanels, TakesHomographiesWhereTheyArePossible) {
  RectificationPlan plan;
  const RigidTransform a = looking_down({0, 0, 100});
  ASSERT_TRUE(plan_panels(distorting_camera(), a, looking_down({20, 0, 100}), depths, {}, plan).ok());
  EXPECT_EQ(plan.method, RectificationMethod::homography);
  EXPECT_EQ(plan.count, 1U);
  EXPECT_EQ(plan.blind_radius_px, 0);
}

TEST(PolarRow, IsTheOneNearestToTheImageWhicheverTurnTheAzimuthIsCountedIn) {
  RectifiedPair pair{.method = RectificationMethod::polar, .height = 200, .focal_px = 100};
  // A sector across the seam: row 0 is azimuth 2.5, the last row 2.5 + 1.99, beyond pi.
  pair.cy = -250;
  for (const double azimuth : {2.6, 3.1, 3.2, 4.4}) {
    for (const int turns : {-2, -1, 0, 1}) {
      EXPECT_NEAR(polar_row(pair, azimuth + 2 * pi * turns), 100 * azimuth - 250, 1e-9) << azimuth << " " << turns;
    }
  }
  // What azimuth_of gives for directions on either side of the seam.
  EXPECT_NEAR(polar_row(pair, azimuth_of({0, std::sin(3.1), std::cos(3.1)})), 60, 1e-9);
  EXPECT_NEAR(polar_row(pair, azimuth_of({0, std::sin(3.2), std::cos(3.2)})), 70, 1e-9);
}

TEST(PlanPanels, RingsAndSectorsOfALargeImageDivideItAndReachBeyondTheirParts) {
  const CameraModel camera = distorting_camera(limits::max_image_width, limits::max_image_height * 3 / 4);
  const RigidTransform a = looking_down({0, 0, 100}), b = looking_down({2, 1, 85}, {0, 0, 0.2});
  RectificationPlan plan;
  ASSERT_TRUE(plan_panels(camera, a, b, depths, {}, plan).ok());
  bool divided = false;
  for (std::size_t i = 0; i + 1 < plan.count; ++i) {
    divided = divided || plan.panels[i].pair.sector.low_cotangent == plan.panels[i + 1].pair.sector.low_cotangent;
  }
  EXPECT_TRUE(divided) << "no ring has two sectors: nothing is tested";
  const double disc = plan.blind_radius_px / (0.5 * (camera.fx + camera.fy));
  const Vec3 along = (centre_of(b) - centre_of(a)).normalized();
  int checked = 0;
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec2 normalised = normalised_from_pixel(camera, Vec2(x, y));
      const Vec3 ray = a.rotation.transpose() * Vec3(normalised.x(), normalised.y(), 1);
      if (std::asin(std::min(1.0, ray.normalized().cross(along).norm())) < disc) continue;
      const Vec2 in_b = pixel_of(camera, b, centre_of(a) + 100 * ray);
      if (!inside(camera, in_b)) continue;
      const RectifiedPanel* panel = panel_at(plan, normalised);
      ASSERT_NE(panel, nullptr) << x << " " << y;
      const Vec2 left = rectified_left(panel->pair, normalised);
      const Vec2 right = rectified_right(panel->pair, normalised_from_pixel(camera, in_b));
      ASSERT_NEAR(left.y(), right.y(), 1e-6);
      // Room for windows and for paths to settle.
      constexpr double capacity = 8;
      ASSERT_TRUE(left.x() > capacity && left.y() > capacity && left.x() < panel->pair.width - 1 - capacity &&
                  left.y() < panel->pair.height - 1 - capacity)
          << x << " " << y;
      ++checked;
    }
  }
  EXPECT_GT(checked, camera.width * camera.height / 2);
}

TEST(PlanPanels, GroundNearerThanTheDescentIsCutFromTheRangeAndSaidSo) {
  RectificationPlan plan;
  const CameraModel camera = distorting_camera(limits::max_image_width, limits::max_image_height * 3 / 4);
  const Status status = plan_panels(camera, looking_down({0, 0, 100}), looking_down({0, 0, 60}), {30, 125}, {}, plan);
  EXPECT_EQ(status.code, StatusCode::disparity_range_exceeded);
  ASSERT_GT(plan.count, 0U);
  for (std::size_t i = 0; i < plan.count; ++i) EXPECT_LE(plan.panels[i].range.count(), limits::max_disparities);
}

TEST(PlanPanels, LimitsHoldWhateverTheMotionAndAttitude) {
  const CameraModel camera = distorting_camera(limits::max_image_width, limits::max_image_height);
  Rng rng(7);
  int planned = 0;
  const RectificationParams params;
  RectificationPlan plan;
  for (int trial = 0; trial < 60; ++trial) {
    const auto draw = [&](double range) { return range * (2 * rng.uniform() - 1); };
    const RigidTransform a = looking_down({0, 0, 100}, {draw(0.3), draw(0.3), draw(3)});
    const RigidTransform b = looking_down({draw(15), draw(15), 100 + draw(30)}, {draw(0.3), draw(0.3), draw(3)});
    const Status status = plan_polar_rectification(camera, a, b, {80, 160}, params, plan);
    if (!status.ok() && !status.is(StatusCode::disparity_range_exceeded)) {
      EXPECT_TRUE(status.b == 4 || status.b == 6) << status.b;
      continue;
    }
    ++planned;
    EXPECT_GE(plan.resolution, params.min_scale - 1e-9);
    for (std::size_t i = 0; i < plan.count; ++i) {
      const auto& [pair, range] = plan.panels[i];
      EXPECT_LE(pair.width, limits::max_rectified_width);
      EXPECT_LE(pair.height, limits::max_rectified_height);
      EXPECT_LE(range.count(), limits::max_disparities);
      EXPECT_GE(range.count(), 1);
    }
  }
  EXPECT_GT(planned, 40);
}

}  // namespace
}  // namespace ilp::test
