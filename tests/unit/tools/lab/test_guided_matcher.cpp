// The second pass of matching, on terraces: the parallax along the rows jumps from one to the next, and some squares
// have moved across the rows. Which place of b shows which place of a is known, and so is the epipolar geometry.
#include <gtest/gtest.h>

#include <cstring>
#include <memory>

#include "fsw/base/argument.hpp"
#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "sim/tools/lab/guided_matcher.hpp"
#include "tests/unit/vision/features/known_pair.hpp"

namespace ilp {
namespace {

struct Terraces {
  static constexpr double levels_px[4] = {0, 14, 28, -16};
  test::Image a{640, 480}, b{640, 480};
  CameraModel camera;
  MatchGuide rows;  ///< y stays

  Terraces() {
    Rng rng(3);
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) {
        const double dy = moves(x, y) ? 4 : 0;
        a.view().at(x, y) = grey(test::fractal_texture(x, y, 5, 1), rng);
        b.view().at(x, y) = grey(test::fractal_texture(x + level(x, y), y - dy, 5, 1), rng);
      }
    }
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 600;
    camera.cx = 319.5;
    camera.cy = 239.5;
    rows.camera_a = rows.camera_b = camera;
    const double y_stays[9] = {0, 0, 0, 0, 0, -1, 0, 1, 0};
    std::memcpy(rows.matrix, y_stays, sizeof(y_stays));
  }
  static std::uint8_t grey(double value, Rng& rng) {
    return static_cast<std::uint8_t>(std::clamp(std::floor(value + 3 * rng.uniform() - 1), 0.0, 255.0));
  }
  static std::uint64_t cell(double x, double y, double side) {
    return mix64(static_cast<std::uint64_t>(std::floor(x / side) + 1000 * std::floor(y / side) + 5000));
  }
  /// x of a - x of b at a place of b.
  static double level(double x, double y) { return levels_px[cell(x, y, 60) % 4]; }
  static bool moves(double x, double y) { return cell(x, y, 30) % 16 == 5; }

  /// Distance of b's place from the nearest place of b that shows a's; large when none does.
  static double error(const Corner& c, double xb, double yb) {
    double nearest = 1e9;
    for (const double shift : levels_px) {
      const double x = c.x - shift;
      if (level(x, c.y) == shift && !moves(x, c.y)) nearest = std::min(nearest, std::hypot(xb - x, yb - c.y));
    }
    return nearest;
  }
};

class Guided : public testing::Test {
 protected:
  void SetUp() override {
    const auto harris = std::make_unique<HarrisWorkspace>();
    ASSERT_TRUE(detect_corners(scene().a.view(), {}, *harris, corners_a_).ok());
    ASSERT_TRUE(detect_corners(scene().b.view(), {}, *harris, corners_b_).ok());
    ASSERT_TRUE(match_and_track_corners(scene().a.view(), corners_a_, scene().b.view(), corners_b_, plane_, params_,
                                        *workspace_, matches_)
                    .ok());
  }
  static const Terraces& scene() {
    static const Terraces terraces;
    return terraces;
  }
  Status guide(const MatchGuide& by, const GuidedParams& guided = {}) {
    return match_guided(scene().a.view(), corners_a_, scene().b.view(), corners_b_, plane_, by, params_, guided,
                        *workspace_, matches_);
  }
  [[nodiscard]] int wrong() const {
    int count = 0;
    for (const Match& m : matches_) count += Terraces::error(corners_a_[m.a], m.xb, m.yb) > 1 ? 1 : 0;
    return count;
  }

  const double plane_[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  MatcherParams params_;
  std::unique_ptr<MatcherWorkspace> workspace_ = std::make_unique<MatcherWorkspace>();
  Corners corners_a_, corners_b_;
  Matches matches_;
};

TEST_F(Guided, MoreMatchesAndFewerWrongOnes) {
  const auto first = static_cast<int>(matches_.size());
  const int first_wrong = wrong();
  ASSERT_TRUE(guide(scene().rows).ok());
  const auto second = static_cast<int>(matches_.size());
  EXPECT_GT(first_wrong, 10) << "the scene must have something to put right";
  EXPECT_GT(second - wrong(), (first - first_wrong) * 102 / 100);
  EXPECT_LT(wrong() * first, first_wrong * second * 2 / 3);
  std::vector<bool> used_b(corners_b_.size());
  int previous = -1;
  for (const Match& m : matches_) {
    EXPECT_LE(std::fabs(static_cast<double>(m.yb) - corners_a_[m.a].y), std::sqrt(2.0) + 1e-3);
    EXPECT_GT(static_cast<int>(m.a), previous);
    previous = m.a;
    ASSERT_LT(m.b, corners_b_.size());
    EXPECT_FALSE(used_b[m.b]);
    used_b[m.b] = true;
    EXPECT_LE(std::hypot(m.xb - corners_b_[m.b].x, m.yb - corners_b_[m.b].y), 3.01);
    EXPECT_GE(m.score, 0.7F);
  }
}

TEST_F(Guided, WithoutFirstMatchesItFindsMostOfThem) {
  const auto first = static_cast<int>(matches_.size()) - wrong();
  matches_.clear();
  ASSERT_TRUE(guide(scene().rows, {.search_radius_px = 40}).ok());
  EXPECT_GT(static_cast<int>(matches_.size()) - wrong(), first * 8 / 10);
  EXPECT_LT(wrong(), static_cast<int>(matches_.size()) / 20);
}

TEST_F(Guided, TheSameAgainIsTheSameToTheLastBit) {
  const Matches first = matches_;
  const Corners corners_b = corners_b_;
  ASSERT_TRUE(guide(scene().rows).ok());
  const Matches once = matches_;
  matches_ = first;
  corners_b_ = corners_b;
  workspace_ = std::make_unique<MatcherWorkspace>();
  ASSERT_TRUE(guide(scene().rows).ok());
  ASSERT_EQ(matches_.size(), once.size());
  EXPECT_EQ(std::memcmp(matches_.data(), once.data(), once.size() * sizeof(Match)), 0);
}

// The levels of the terraces are 14 px apart: a plane knows one of them.
TEST_F(Guided, APlaneKeepsWhatLiesOnIt) {
  MatchGuide ground = scene().rows;
  ground.kind = GuideKind::plane;
  const double shift[9] = {1, 0, -14, 0, 1, 0, 0, 0, 1};
  std::memcpy(ground.matrix, shift, sizeof(shift));
  int on_level = 0;
  for (const Match& m : matches_) on_level += std::fabs(corners_a_[m.a].x - 14 - m.xb) < 1 ? 1 : 0;
  ASSERT_TRUE(guide(ground).ok());
  EXPECT_GE(static_cast<int>(matches_.size()), on_level);
  EXPECT_GT(on_level, 80);
  for (const Match& m : matches_) {
    EXPECT_LE(std::hypot(m.xb - (corners_a_[m.a].x - 14), m.yb - corners_a_[m.a].y), 1.001);
  }
}

TEST_F(Guided, GuideOfAPoseIsItsEpipolarGeometry) {
  RigidTransform b_from_a;
  b_from_a.rotation << 0.96, -0.28, 0, 0.28, 0.96, 0, 0, 0, 1;
  b_from_a.translation = Vec3(0.3, -0.1, 0.05);
  CameraModel other = scene().camera;
  other.fx = 450;
  other.cy = 260;
  const MatchGuide by = guide_of_pose(b_from_a, scene().camera, other);
  for (const Vec3& x : {Vec3(0.2, 0.1, 2), Vec3(-0.7, 0.5, 3), Vec3(1, -1, 5)}) {
    const Vec3 y = b_from_a * x;
    const Vec3 a(600 * x.x() / x.z() + 319.5, 600 * x.y() / x.z() + 239.5, 1);
    const Vec3 b(450 * y.x() / y.z() + 319.5, 600 * y.y() / y.z() + 260, 1);
    Mat3 f;
    for (int i = 0; i < 9; ++i) f(i / 3, i % 3) = by.matrix[i];
    EXPECT_NEAR(b.dot(f * a) / (f * a).head<2>().norm(), 0, 1e-9);
  }
}

TEST_F(Guided, RefusesBadArguments) {
  const Matches first = matches_;
  const auto refused = [&](const MatchGuide& by, const GuidedParams& guided, Argument which) {
    const Status status = guide(by, guided);
    EXPECT_TRUE(status.is(StatusCode::invalid_argument)) << status_name(status.code);
    EXPECT_EQ(static_cast<Argument>(status.a), which);
    matches_ = first;
  };
  MatchGuide bad = scene().rows;
  bad.matrix[3] = std::nan("");
  refused(bad, {}, Argument::guide);
  refused(MatchGuide{GuideKind::line, {}, scene().camera, scene().camera}, {}, Argument::guide);
  refused(scene().rows, {.max_distance_px = std::nanf("")}, Argument::match_parameters);
  refused(scene().rows, {.search_radius_px = 0}, Argument::match_parameters);
  matches_[3].b = matches_[2].b;
  refused(scene().rows, {}, Argument::match);
  matches_[3].a = 2047;
  refused(scene().rows, {}, Argument::match);
  bad = scene().rows;
  bad.camera_b.fx = 0;
  EXPECT_FALSE(guide(bad).ok());
}

}  // namespace
}  // namespace ilp
