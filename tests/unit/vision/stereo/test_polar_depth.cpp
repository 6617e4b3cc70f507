// Polar rectification: descents, ascents and oblique motion over known terrain, the epipole inside, at the edge of and
// outside the image.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>

#include "fsw/base/math.hpp"
#include "fsw/vision/stereo/polar_rectification.hpp"
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

  [[nodiscard]] double quantile(const std::vector<double>& v, double q) const {
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
  EXPECT_LT(median_px, 0.15);
  EXPECT_LT(s.quantile(s.errors_px, 0.95), 0.6);
  EXPECT_LT(median, 0.01);
  EXPECT_GT(s.valid / s.shared, 0.93);
  EXPECT_LT(s.claimed_elsewhere / s.shared, 0.015);  // a seam of about one pixel around the common view
  EXPECT_GT(s.within_two / s.valid, 0.85);
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

}  // namespace
}  // namespace ilp::test
