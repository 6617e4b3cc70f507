// The same bytes with vectors of 16 bytes, which every processor has, and with the widest of this one.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>

#include "fsw/base/rng.hpp"
#include "fsw/base/vector_width.hpp"
#include "fsw/vision/stereo/depth/depth.hpp"
#include "fsw/vision/stereo/match/stereo_matcher.hpp"
#include "fsw/vision/stereo/rectify/rectification_plan.hpp"
#include "fsw/vision/stereo/rectify/resample.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {
namespace {

/// Calls `compute` with both widths and compares what it returns.
template <typename Compute>
void expect_same(Compute compute) {
  use_vectors(VectorWidth::bytes16);
  const auto narrow = compute();
  use_vectors(widest_vectors());
  const auto wide = compute();
  ASSERT_EQ(narrow.size(), wide.size());
  ASSERT_FALSE(narrow.empty());
  for (std::size_t i = 0; i < narrow.size(); ++i) {
    ASSERT_EQ(std::memcmp(&narrow[i], &wide[i], sizeof narrow[i]), 0)
        << "value " << i << ": " << +narrow[i] << " and " << +wide[i];
  }
}

class VectorWidths : public ::testing::Test {
 protected:
  ~VectorWidths() override { use_vectors(widest_vectors()); }
  void SetUp() override {
    if (widest_vectors() == VectorWidth::bytes16) GTEST_SKIP() << "this processor has vectors of 16 bytes only";
  }
};

/// Ground with steps, slopes, a blank field and noise, under masks that cut corners off; the width is a multiple of no
/// vector.
struct Pair {
  static constexpr std::int32_t width = 331, height = 203;
  Image left{width, height}, right{width, height};
  std::vector<std::uint8_t> left_valid, right_valid;

  Pair() : left_valid(left.pixels.size(), 255), right_valid(left.pixels.size(), 255) {
    Rng rng(7);
    const auto noisy = [&](double grey) {
      return static_cast<std::uint8_t>(std::clamp(grey + 6 * rng.uniform() - 3, 0.0, 255.0));
    };
    for (std::int32_t y = 0; y < height; ++y) {
      for (std::int32_t x = 0; x < width; ++x) {
        const bool blank = x > 200 && y > 120;
        const double shift = ((x / 80 + y / 70) % 2 == 0 ? 18 : 30) + 0.05 * y;
        left.view().at(x, y) = noisy(blank ? 120 : fractal_texture(x, y, 3, 5));
        right.view().at(x, y) = noisy(blank ? 120 : fractal_texture(x + shift, y, 3, 5));
        const std::size_t k = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
        if (x + y < 40) left_valid[k] = 0;
        if (width - x + y < 50 || y > height - 4) right_valid[k] = 0;
      }
    }
  }
};

std::vector<float> matched(const Pair& pair, StereoMatcherChoice choice, std::int32_t disparities, int radius) {
  static const auto workspace = std::make_unique<StereoWorkspace>();
  const std::size_t pixels = pair.left.pixels.size();
  std::vector<float> both(2 * pixels);
  StereoParams params{.matcher = choice, .window_radius = radius};
  StereoMatcher matcher;
  const Status begun =
      matcher.begin(pair.left.view(), pair.right.view(), {pair.left_valid.data(), Pair::width, Pair::height},
                    {pair.right_valid.data(), Pair::width, Pair::height}, {0, disparities - 1}, params, *workspace,
                    {{both.data(), Pair::width, Pair::height}, {both.data() + pixels, Pair::width, Pair::height}});
  EXPECT_TRUE(begun.ok() && do_all([&] { return matcher.step(16); }).ok());
  return both;
}

TEST_F(VectorWidths, MatchTheSameDisparitiesWithTheSameErrors) {
  const Pair pair;
  for (const StereoMatcherChoice choice : {StereoMatcherChoice::semi_global, StereoMatcherChoice::ordered_scanline}) {
    // One vector of 16, of 32, odd and even numbers of vectors, the whole range, and what the coarse map narrows.
    for (const std::int32_t disparities : {12, 32, 47, 64, 100, 256}) {
      for (const int radius : {1, 2, 4}) {
        SCOPED_TRACE(testing::Message() << disparities << " disparities, radius " << radius);
        expect_same([&] { return matched(pair, choice, disparities, radius); });
      }
    }
  }
}

/// A pair with distortion; across the view, or along it, which is rectified in polar panels.
class Rectified {
 public:
  explicit Rectified(const Vec3& translation) {
    camera.width = 333;
    camera.height = 251;
    camera.fx = 300;
    camera.fy = 290;
    camera.cx = 160;
    camera.cy = 120;
    camera.k1 = -0.1;
    camera.k2 = 0.01;
    camera.p1 = 4e-4;
    camera.p2 = -3e-4;
    RigidTransform right{.translation = translation};
    EXPECT_TRUE(plan_panels(camera, {}, right, {80, 125}, {}, *plan).ok());
    EXPECT_GT(plan->count, 0U);
  }

  CameraModel camera;
  std::unique_ptr<RectificationPlan> plan = std::make_unique<RectificationPlan>();
};
const Vec3 across(-20, 1, 0.5), along(0.3, -0.2, -9);

TEST_F(VectorWidths, ResampleTheSameGreyValues) {
  for (const Vec3& translation : {across, along}) {
    const Rectified r(translation);
    const Image image = render_texture(r.camera.width, r.camera.height, {1, 0, 40, 90}, 1, 0, 2, 1);
    for (std::size_t i = 0; i < r.plan->count; ++i) {
      const RectifiedPair& pair = r.plan->panels[i].pair;
      const auto pixels = static_cast<std::size_t>(pair.width) * static_cast<std::size_t>(pair.height);
      expect_same([&] {
        std::vector<std::uint8_t> both(2 * pixels);
        EXPECT_TRUE(resample_rows(pair, Side::right, r.camera, image.view(), 0, pair.height,
                                  {both.data(), pair.width, pair.height},
                                  {both.data() + pixels, pair.width, pair.height})
                        .ok());
        return both;
      });
    }
  }
}

TEST_F(VectorWidths, GiveTheSameDepthWithTheSameErrors) {
  for (const Vec3& translation : {across, along}) {
    const Rectified r(translation);
    for (std::size_t i = 0; i < r.plan->count; ++i) {
      const auto& [pair, range] = r.plan->panels[i];
      const auto pixels = static_cast<std::size_t>(pair.width) * static_cast<std::size_t>(pair.height);
      std::vector<float> disparity(pixels), sigma(pixels);
      std::vector<DisparityKind> kind(pixels);
      Rng rng(3);
      for (std::size_t k = 0; k < pixels; ++k) {
        // Also steps, empty pixels, and supported ones.
        const double chance = rng.uniform();
        disparity[k] = static_cast<float>(range.min_px + 0.4 * (range.max_px - range.min_px) + 1.2 * chance);
        sigma[k] = chance < 0.1 ? 0.0F : static_cast<float>(0.1 + chance);
        if (chance < 0.2) kind[k] = DisparityKind::supported;
      }
      const std::size_t area = static_cast<std::size_t>(r.camera.width) * static_cast<std::size_t>(r.camera.height);
      expect_same([&] {
        std::vector<float> both(2 * area);
        const std::int32_t words = supported_words(r.camera.width);
        std::vector<std::uint64_t> supported(static_cast<std::size_t>(words * r.camera.height));
        EXPECT_TRUE(depth_rows(pair, r.camera,
                               {{disparity.data(), pair.width, pair.height},
                                {sigma.data(), pair.width, pair.height},
                                {kind.data(), pair.width, pair.height}},
                               0, r.camera.height,
                               {{both.data(), r.camera.width, r.camera.height},
                                {both.data() + area, r.camera.width, r.camera.height},
                                {supported.data(), words, r.camera.height}})
                        .ok());
        for (const std::uint64_t word : supported) both.push_back(static_cast<float>(std::popcount(word)));
        return both;
      });
    }
  }
}

}  // namespace
}  // namespace ilp::test
