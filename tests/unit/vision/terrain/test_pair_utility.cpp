// What pairs promise, against the geometry of level flights and descents over a plane.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "fsw/vision/terrain/pair_utility.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp::test {
namespace {

constexpr double height = 100;

class PairUtilityTest : public ::testing::Test {
 protected:
  PairUtilityTest() : coverage_(std::make_unique<Coverage>()) {
    camera_.k1 = camera_.k2 = camera_.p1 = camera_.p2 = 0;
    EXPECT_TRUE(clear_coverage(camera_.width, camera_.height, *coverage_).ok());
  }

  [[nodiscard]] PairUtility utility_of(const Vec3& second) const {
    const RigidTransform first = looking_down(Vec3(0, 0, height), {0, 0, 0});
    return pair_utility(camera_, compose(looking_down(second, {0, 0, 0}), inverse(first)), height, *coverage_, {});
  }
  void know_all(double sampling, double sigma) {
    for (std::int32_t y = 0; y < camera_.height; ++y) {
      for (std::int32_t x = 0; x < camera_.width; ++x) coverage_->cover(x, y, seen_quality(sampling, sigma));
    }
  }

  CameraModel camera_ = distorting_camera();
  std::unique_ptr<Coverage> coverage_;
};

TEST_F(PairUtilityTest, LevelFlightHasTheSigmaOfItsParallaxAndTheNextKeyframeIsWorthMost) {
  const double width = height * camera_.width / camera_.fx;
  const PairUtility next = utility_of({0.18 * width, 0, height});
  EXPECT_NEAR(next.common, 0.82, 0.04);
  EXPECT_NEAR(next.median_sigma, 0.1 / (0.18 * camera_.width), 1e-5);
  for (int step = 2; step <= 4; ++step)
    EXPECT_LT(utility_of({0.18 * step * width, 0, height}).utility, next.utility) << step;
}

TEST_F(PairUtilityTest, InADescentOverKnownCoarseGroundAFartherPartnerIsWorthMoreAndOverNewGroundTheNext) {
  const auto down = [&](int steps) { return utility_of({0, 0, height * std::pow(0.93, steps)}); };
  EXPECT_GT(down(1).utility, down(4).utility) << "ground at the border is lost otherwise";
  EXPECT_NEAR(down(4).common, std::pow(0.93, 8), 0.06);
  EXPECT_LT(down(4).median_sigma, 0.5 * down(1).median_sigma);
  know_all(height / camera_.fx * 2, 0.015);
  EXPECT_GT(down(4).utility, 1.2 * down(1).utility);
}

TEST_F(PairUtilityTest, GroundThatIsKnownAsWellAndGroundThatIsSeenBadlyAreWorthNothing) {
  EXPECT_EQ(utility_of({0.1, 0, height}).utility, 0) << "parallax below 5 px everywhere";
  EXPECT_GT(utility_of({0.1, 0, height}).median_sigma, 0.02);
  EXPECT_GT(utility_of({20, 0, height}).utility, 0);
  know_all(height / camera_.fx, 0.001);
  EXPECT_EQ(utility_of({20, 0, height}).utility, 0);
}

TEST_F(PairUtilityTest, WithoutCommonGroundOrDistanceThereIsNothing) {
  EXPECT_EQ(utility_of({300, 0, height}).common, 0);
  EXPECT_EQ(utility_of({0, 0, -1}).common, 0);
  EXPECT_EQ(pair_utility(camera_, {}, 0, *coverage_, {}).utility, 0);
  EXPECT_EQ(utility_of({85, 0, height}).utility, 0) << "too little of it";
}

}  // namespace
}  // namespace ilp::test
