// Gaps on a plane of known disparity, in images of weak texture that the test makes.
#include "fsw/vision/stereo/match/gap_support.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace ilp {
namespace {

constexpr std::int32_t width = 120, height = 90;

struct Map {
  std::vector<float> disparity_px = std::vector<float>(width * height), sigma_px = disparity_px;
  std::vector<DisparityKind> kind;

  [[nodiscard]] DisparityView view() {
    return {{disparity_px.data(), width, height}, {sigma_px.data(), width, height}, {kind.data(), width, height}};
  }
};

/// Ground with the disparity 10 + slope x and a gap in it, whose texture both images see, or each its own noise only.
struct Scene {
  std::vector<std::uint8_t> left, right, valid;
  Map map;
  double noise_grey = 0.4;
  bool right_sees_it = true;
  bool island = false;  ///< a tenth of the gap is bright, and both images see it
  double slope = 0.05;
  double step_px = 0;  ///< of the disparity on the right side of the gap

  [[nodiscard]] double disparity(double x) const { return 10 + slope * x; }
  static bool in_island(double x, double y, double rim) { return x >= 54 - rim && x < 62 + rim && y >= 42 && y < 48; }
  static bool in_gap(std::int32_t x, std::int32_t y) { return x >= 50 && x < 66 && y >= 30 && y < 60; }

  void make(unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    // Waves as weak as 2 grey levels.
    const auto grey = [](double x, double y) {
      return 100 + std::sin(0.7 * x + 0.3 * y) + std::cos(0.5 * x - 0.6 * y);
    };
    left.assign(width * height, 0);
    right = left;
    valid.assign(width * height, 1);
    map = {};
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const auto i = static_cast<std::size_t>(y * width + x);
        // The right pixel x shows the ground of the left one at x + d, with d of that ground.
        const double ground = (x + 10.0) / (1 - slope);
        const auto levels = [&](double level) {
          return static_cast<std::uint8_t>(std::lround(level + noise_grey * normal(random)));
        };
        // Its rim is wider in the right image, so that no pixel of the left one lies on it.
        const bool left_island = island && in_island(x, y, 0);
        const bool right_island = island && in_island(ground, y, 2);
        left[i] = levels(grey(x, y) + (left_island ? 40 : 0));
        right[i] = levels(right_sees_it || right_island ? grey(ground, y) + (right_island ? 40 : 0) : 100);
        map.disparity_px[i] = static_cast<float>(disparity(x) + (x >= 66 ? step_px : 0));
        map.sigma_px[i] = in_gap(x, y) ? 0.0F : 0.1F;
      }
    }
  }

  void support() {
    NccRows rows;
    rows.left = {left.data(), width, height};
    rows.right = {right.data(), width, height};
    rows.left_valid = {valid.data(), width, height};
    rows.right_valid = {valid.data(), width, height};
    map.kind.assign(width * height, DisparityKind::measured);
    for (std::size_t i = 0; i < map.kind.size(); ++i) {
      if (map.sigma_px[i] == 0) map.kind[i] = DisparityKind::none;
    }
    const StereoParams params;
    const auto gaps = std::make_unique<GapWorkspace>();
    const auto segments = std::make_unique<PixelForest>();
    begin_gaps(*gaps);
    for (std::int32_t y = 0; y < height; ++y) {
      propose_gap_row(rows, params, y, map.view(), *gaps);
      connect_gap_row(rows.left_valid, map.view(), y, *segments);
    }
    for (std::int32_t y = 0; y < height; ++y) accept_gap_row(map.view(), y, *segments);
  }

  /// Calls `see(x, disparity, sigma)` for each supported pixel; returns the number of gap pixels.
  template <typename See>
  int look(See see) const {
    int pixels = 0;
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const auto i = static_cast<std::size_t>(y * width + x);
        EXPECT_EQ(map.sigma_px[i] > 0, map.kind[i] != DisparityKind::none);
        if (map.kind[i] == DisparityKind::supported) see(x, y, map.disparity_px[i], map.sigma_px[i]);
        if (in_gap(x, y)) ++pixels;
      }
    }
    return pixels;
  }
  [[nodiscard]] int supported() const {
    int count = 0;
    look([&](std::int32_t, std::int32_t, float, float) { ++count; });
    return count;
  }
};

TEST(GapSupport, WeakTextureThatBothImagesSeeTakesThePlaneAroundIt) {
  Scene scene;
  scene.make(1);
  scene.support();
  int count = 0, within_one = 0;
  const int pixels = scene.look([&](std::int32_t x, std::int32_t y, float d, float sigma) {
    ++count;
    EXPECT_TRUE(Scene::in_gap(x, y));
    EXPECT_NEAR(static_cast<double>(d), scene.disparity(x), 0.1);
    EXPECT_GE(sigma, 0.2F);
    within_one += std::fabs(static_cast<double>(d) - scene.disparity(x)) < static_cast<double>(sigma) ? 1 : 0;
  });
  EXPECT_GT(count, 0.9 * pixels);
  EXPECT_EQ(within_one, count);
}

/// Mean estimated error of the supported pixels.
double mean_sigma(const Scene& scene) {
  double sum = 0;
  int count = 0;
  scene.look([&](std::int32_t, std::int32_t, float, float sigma) {
    sum += static_cast<double>(sigma);
    ++count;
  });
  EXPECT_GT(count, 0);
  return sum / count;
}

/// Makes the scene level, as it was before support, and returns the mean estimated error that support gives its gap.
double make_level(Scene& scene) {
  scene.slope = 0;
  scene.make(1);
  scene.support();
  const double sigma = mean_sigma(scene);
  scene.make(1);
  return sigma;
}

/// Calls `change(x, y, index of the pixel)` in the columns of the gap, from the top to the bottom of the view.
template <typename Change>
void in_columns_of_gap(Change change) {
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 50; x < 66; ++x) change(x, y, static_cast<std::size_t>(y * width + x));
  }
}

TEST(GapSupport, WherePlanesOfSeveralDirectionsDisagreeTheStatedErrorIsLarger) {
  Scene scene;
  const double agreeing = make_level(scene);
  // The matches above and below the gap are 0.8 px nearer than those beside it.
  in_columns_of_gap([&](std::int32_t x, std::int32_t y, std::size_t pixel) {
    if (!Scene::in_gap(x, y)) scene.map.disparity_px[pixel] += 0.8F;
  });
  scene.support();
  EXPECT_GT(mean_sigma(scene), 1.3 * agreeing);
}

TEST(GapSupport, APlaneThatNoOtherDirectionConfirmsHasALargerStatedError) {
  Scene scene;
  const double confirmed = make_level(scene);
  // The gap reaches from the top to the bottom of the view: only matches to its left and right are opposite.
  in_columns_of_gap([&](std::int32_t, std::int32_t, std::size_t pixel) { scene.map.sigma_px[pixel] = 0; });
  scene.support();
  double sum = 0;
  int count = 0;
  // At the edge of the view, where the diagonals do not end in matches either.
  scene.look([&](std::int32_t x, std::int32_t y, float, float sigma) {
    if (y >= 4 || x < 56 || x >= 60) return;
    sum += static_cast<double>(sigma);
    ++count;
  });
  ASSERT_GT(count, 0);
  EXPECT_GT(sum / count, 1.3 * confirmed);
}

TEST(GapSupport, NoiseIsNoGround) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene{.noise_grey = 1, .right_sees_it = false};
    scene.make(seed);
    scene.support();
    EXPECT_EQ(scene.supported(), 0) << seed;
  }
}

TEST(GapSupport, ADepthEdgeIsNotBridged) {
  Scene scene;
  scene.make(1);
  scene.support();
  const int without = scene.supported();
  scene.step_px = 3;
  scene.make(1);
  scene.support();
  // Only what matches above and below it support.
  EXPECT_LE(scene.supported(), without);
  scene.look([&](std::int32_t x, std::int32_t, float d, float) {
    EXPECT_NEAR(static_cast<double>(d), scene.disparity(x), 0.1);
  });
}

TEST(GapSupport, AGapThatIsHardlySeenAgainStaysEmptyWithWhatIs) {
  Scene scene{.right_sees_it = false, .island = true};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    scene.make(seed);
    scene.support();
    EXPECT_EQ(scene.supported(), 0) << seed;
  }
}

TEST(GapSupport, AGapAtTheEdgeOfTheViewOrFartherThanItsReachStaysEmpty) {
  Scene scene{.slope = 0};
  scene.make(1);
  for (std::int32_t y = 0; y < height; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      const bool match = x == 0 || x == width - 1;
      scene.map.sigma_px[static_cast<std::size_t>(y * width + x)] = match ? 0.1F : 0.0F;
    }
  }
  scene.support();
  EXPECT_EQ(scene.supported(), 0);
}

TEST(GapSupport, AMapWithoutGapsOrWithoutMatchesStaysAsItIs) {
  for (const float sigma : {0.1F, 0.0F}) {
    Scene scene;
    scene.make(1);
    scene.map.sigma_px.assign(width * height, sigma);
    const std::vector<float> before = scene.map.disparity_px;
    scene.support();
    EXPECT_EQ(scene.map.sigma_px, std::vector<float>(width * height, sigma));
    EXPECT_EQ(scene.map.disparity_px, before);
  }
}

}  // namespace
}  // namespace ilp
